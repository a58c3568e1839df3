/* medium/method.c: which integrator runs in a medium.
 *
 * auto takes the closed form where there is one. Else nystrom: bench/rays.py finds it the cheapest adaptive method, in
 * gradient evaluations at the error achieved, at every tolerance and on smooth and kinked fields alike (a kink costs a
 * one-step method no new start); its own choice of order follows the tolerance (cl/shared/step.h). The others follow in
 * the order of what they cost there. Fixed steps change nothing in that.
 *
 * Tables are smooth to the second derivative only; nystrom's estimate sees their knots (cl/shared/step.h), so that it
 * is the cheapest there too. */
#include "method.h"

#define METHODS 7

static const int32_t preferred[METHODS] = {CPM_METHOD_NYSTROM,  CPM_METHOD_ADAMS, CPM_METHOD_DOPRI5,  CPM_METHOD_EULER,
                                           CPM_METHOD_YOSHIDA6, CPM_METHOD_RK4,   CPM_METHOD_LEAPFROG};

int32_t cpm_method_in(const cpm_medium *medium, int32_t asked, uint32_t exclude, double step) {
    if (cpm_medium_is_uniform(medium)) return CPM_METHOD_EXACT;
    if (asked != CPM_METHOD_AUTO) return asked;
    if (cpm_medium_has_exact(medium) && !(exclude >> CPM_METHOD_EXACT & 1u)) return CPM_METHOD_EXACT;
    for (size_t i = 0; i < METHODS; i++)
        if (!(exclude >> preferred[i] & 1u) && (step > 0.0 || !cpm_method_needs_step(preferred[i])))
            return preferred[i];
    return CPM_METHOD_AUTO;
}

int cpm_method_needs_step(int32_t method) {
    return method == CPM_METHOD_RK4 || method == CPM_METHOD_LEAPFROG || method == CPM_METHOD_YOSHIDA6;
}

const char *cpm_method_text(int32_t method) {
    static const char *const text[] = {"auto",    "exact", "euler",    "rk4",     "dopri5",
                                       "nystrom", "adams", "leapfrog", "yoshida6"};
    return method >= 0 && method < (int32_t)(sizeof text / sizeof *text) ? text[method] : "unknown";
}

double cpm_method_rtol(int32_t method, double asked) {
    return asked > 0.0 ? asked : method == CPM_METHOD_EULER ? 1e-2 : 1e-6;
}
