/* shared/arctangent.h: atan2 of one double, the same bits on both sides; error below 2 ulp.
 *
 * atan t for t = min/max in [0, 1]; above tan(pi/8) by atan t = pi/4 + atan((t - 1)/(t + 1)), so |t| <= 0.41422; Taylor
 * to t^45, whose next term is below 1e-19. */
#ifndef CPM_SHARED_ARCTANGENT_H
#define CPM_SHARED_ARCTANGENT_H
#include "../dialect.h"

#define CPM_PI 3.14159265358979323846

/* The angle of (x, y) in (-pi, pi]; 0 at the origin. Finite arguments. */
CPM_INLINE double cpm_atan2(double y, double x) {
    double a = fabs(x), b = fabs(y), large = a > b ? a : b, small = a > b ? b : a;
    if (!(large > 0.0)) return 0.0;
    double t = small / large, offset = 0.0;
    if (t > 0.41421356237309503) {
        t = (small - large) / (small + large);
        offset = 0.25 * CPM_PI;
    }
    double z = t * t, sum = 0.0;
    for (int k = 45; k >= 3; k -= 2) sum = (((k & 2) ? -1.0 : 1.0) / (double)k + sum) * z;
    double angle = offset + (t + t * sum);
    if (b > a) angle = 0.5 * CPM_PI - angle;
    if (x < 0.0) angle = CPM_PI - angle;
    return y < 0.0 ? -angle : angle;
}
#endif
