/* The functions of cl/shared/elementary_more.h over arrays, compiled by the test that loads it. */
#include "cl/shared/elementary_more.h"

#define OF_ONE(f)                                                                                                      \
    void test_##f(const double *x, const double *y, double *out, long count) {                                         \
        (void)y;                                                                                                       \
        for (long i = 0; i < count; i++) out[i] = cpm_##f(x[i]);                                                       \
    }
OF_ONE(exp)
OF_ONE(log)
OF_ONE(atan)
OF_ONE(asin)
OF_ONE(acos)
OF_ONE(tan)
OF_ONE(sinh)
OF_ONE(cosh)
OF_ONE(tanh)
void test_atan2(const double *x, const double *y, double *out, long count) {
    for (long i = 0; i < count; i++) out[i] = cpm_atan2(x[i], y[i]);
}
