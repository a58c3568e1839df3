/* scene/rays.h: rays of a scene, for those who want the rays themselves. Internal. */
#ifndef CPM_SCENE_RAYS_H
#define CPM_SCENE_RAYS_H
#include "api/context.h"

/* cpm_rays_trace with a scene: a ray ends at the first surface, at its length or at the plane. The request has been
 * checked, its directions and origins are finite. */
cpm_status cpm_scene_rays_trace(cpm_context *context, cpm_scene *scene, const cpm_rays_request *request,
                                cpm_rays_result *result);
#endif
