/* cpm/status.h: what every fallible call returns, and how a ray ends.
 *
 * Both lists are X-macros, so that the enum and its text cannot drift apart. Values are explicit, have gaps, and are
 * never renumbered. */
#ifndef CPM_STATUS_H
#define CPM_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define CPM_API __attribute__((visibility("default")))
#else
#define CPM_API
#endif

/* X(name, value, text) */
#define CPM_STATUS_LIST(X)                                                                                             \
    X(CPM_OK, 0, "no error")                                                                                           \
    X(CPM_ERROR_INVALID_ARGUMENT, 1, "invalid argument")                                                               \
    X(CPM_ERROR_OUT_OF_MEMORY, 2, "out of memory")                                                                     \
    X(CPM_ERROR_UNSUPPORTED, 3, "not supported")                                                                       \
    X(CPM_ERROR_IO, 4, "file could not be read or written")                                                            \
    X(CPM_ERROR_CANCELLED, 5, "cancelled by the progress callback")                                                    \
    X(CPM_ERROR_BACKEND, 6, "backend failed")                                                                          \
    X(CPM_ERROR_INTERNAL, 20, "internal error")

typedef enum cpm_status {
#define CPM_STATUS_ENUM(name, value, text) name = value,
    CPM_STATUS_LIST(CPM_STATUS_ENUM)
#undef CPM_STATUS_ENUM
} cpm_status;

/* How a ray ended. */
#define CPM_RAY_STATUS_LIST(X)                                                                                         \
    X(CPM_RAY_ARRIVED, 0, "arrived")                             /* at the length or the plane asked for */            \
    X(CPM_RAY_HIT, 1, "hit")                                     /* on a surface of the scene */                       \
    X(CPM_RAY_LEFT, 2, "left")                                   /* crossed the scene's extent outward */              \
    X(CPM_RAY_EVALUATIONS_EXHAUSTED, 10, "evaluations_exhausted") /* max_evaluations reached first */                  \
    X(CPM_RAY_STEP_UNDERFLOW, 11, "step_underflow")              /* no step meets the tolerance */                     \
    X(CPM_RAY_CUTOFF, 12, "cutoff")                              /* n fell below 1e-6 of its start */                  \
    X(CPM_RAY_CAPTURED, 13, "captured")                          /* fell into a singular centre */

typedef enum cpm_ray_status {
#define CPM_RAY_STATUS_ENUM(name, value, text) name = value,
    CPM_RAY_STATUS_LIST(CPM_RAY_STATUS_ENUM)
#undef CPM_RAY_STATUS_ENUM
} cpm_ray_status;

/* Text of a status; never NULL, "unknown status" for a value outside the list. */
CPM_API const char *cpm_status_string(cpm_status status);
CPM_API const char *cpm_ray_status_string(cpm_ray_status status);

#ifdef __cplusplus
}
#endif
#endif
