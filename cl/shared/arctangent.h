/* shared/arctangent.h: pi, and the angle of a point: cpm_atan2 of elementary_more.h. */
#ifndef CPM_SHARED_ARCTANGENT_H
#define CPM_SHARED_ARCTANGENT_H
#include "elementary_more.h"

#define CPM_PI 3.14159265358979323846
#endif
