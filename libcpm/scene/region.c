/* scene/region.c: which bounded media contain a point. */
#include "cl/shared/region_at.h"
#include "pass.h"

cpm_region cpm_region_at(const cpm_pass *pass, cpm_vec point, cpm_vec direction) {
    return world_region_at(&pass->world, point, direction);
}
