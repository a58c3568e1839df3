/* geometry/embree.h: hides the difference between Embree 3 and 4; included by geometry files only. */
#ifndef CPM_GEOMETRY_EMBREE_H
#define CPM_GEOMETRY_EMBREE_H
#ifndef CPM_EMBREE_MAJOR /* the build says which it links */
#define CPM_EMBREE_MAJOR (__has_include(<embree4/rtcore.h>) && !__has_include(<embree3/rtcore.h>) ? 4 : 3)
#endif
#if CPM_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#define CPM_EMBREE 4
typedef struct RTCRayQueryContext cpm_embree_context;
#else
#include <embree3/rtcore.h>
#define CPM_EMBREE 3
typedef struct RTCIntersectContext cpm_embree_context;
#endif

static inline void cpm_embree_context_init(cpm_embree_context *context) {
#if CPM_EMBREE == 4
    rtcInitRayQueryContext(context);
#else
    rtcInitIntersectContext(context);
    context->flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
#endif
}

static inline void cpm_embree_intersect(RTCScene scene, cpm_embree_context *context, struct RTCRayHit *ray) {
#if CPM_EMBREE == 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = context;
    rtcIntersect1(scene, ray, &arguments);
#else
    rtcIntersect1(scene, context, ray);
#endif
}

/* Four rays, those whose `valid` is -1. */
static inline void cpm_embree_intersect4(const int *valid, RTCScene scene, cpm_embree_context *context,
                                         struct RTCRayHit4 *rays) {
#if CPM_EMBREE == 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = context;
    rtcIntersect4(valid, scene, rays, &arguments);
#else
    rtcIntersect4(valid, scene, context, rays);
#endif
}

/* Any hit: tfar becomes -infinity. */
static inline void cpm_embree_occluded(RTCScene scene, cpm_embree_context *context, struct RTCRay *ray) {
#if CPM_EMBREE == 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = context;
    rtcOccluded1(scene, ray, &arguments);
#else
    rtcOccluded1(scene, context, ray);
#endif
}
#endif
