/* scene/world.h: a pass as its rays see it: the tables of cl/types/world.h. */
#ifndef CPM_SCENE_WORLD_H
#define CPM_SCENE_WORLD_H
#include "pass.h"

/* pass->world, once all else of the pass is known; 0: no memory. */
int cpm_world_begin(cpm_pass *pass);
void cpm_world_end(cpm_pass *pass);
#endif
