/* medium/method.h: which integrator runs in a medium. */
#ifndef CPM_MEDIUM_METHOD_H
#define CPM_MEDIUM_METHOD_H
#include "cpm/ray.h"
#include "medium.h"

#define CPM_METHOD_LAST CPM_METHOD_YOSHIDA6

/* The cpm_method that runs where `asked` is asked for; CPM_METHOD_AUTO: none is left. `exclude` has a bit 1 << method
 * for each that AUTO may not take. A uniform medium runs none: CPM_METHOD_EXACT. */
int32_t cpm_method_in(const cpm_medium *medium, int32_t asked, uint32_t exclude, double step);
/* Methods of fixed steps, which a request must give. */
int cpm_method_needs_step(int32_t method);
const char *cpm_method_text(int32_t method); /* "nystrom" */
/* rtol where none is asked for. */
double cpm_method_rtol(int32_t method, double asked);
#endif
