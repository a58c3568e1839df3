/* backend/native/parabolas.h: what follow_parabolas.c defines, for each instruction set. */
#ifndef CPM_NATIVE_PARABOLAS_H
#define CPM_NATIVE_PARABOLAS_H
#include "follow.h"

#define CPM_PARABOLAS 64 /* flights a lot: their curves and hits stay in the first cache */

/* All flights that start in `medium`, whose n^2 is linear. */
typedef void (*cpm_parabolas)(const cpm_pass *pass, const cpm_flight *flights, size_t count, int32_t medium,
                              cpm_arrival *arrivals);
cpm_parabolas cpm_parabolas_chosen(void);
#endif
