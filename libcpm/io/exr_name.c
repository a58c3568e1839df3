/* io/exr_name.c: how a spectral channel is called. Needs no OpenEXR. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/exr.h"

#define MOST_DECIMALS 17

void cpm_exr_channel_name(double wavelength, char name[CPM_EXR_NAME_SIZE]) {
    char number[CPM_EXR_NAME_SIZE];
    int fits = 0;
    if (wavelength >= 1e-3 && wavelength < 1e7)
        for (int decimals = 3; decimals <= MOST_DECIMALS && !fits; decimals++) {
            snprintf(number, sizeof number, "%.*f", decimals, wavelength);
            fits = strtod(number, NULL) == wavelength; /* both sides speak the locale's decimal sign */
        }
    if (!fits) snprintf(number, sizeof number, "%.16e", wavelength);
    /* The first character that is no digit is the decimal sign, whatever the locale calls it. */
    const size_t whole = strspn(number, "0123456789");
    number[whole] = ',';
    snprintf(name, CPM_EXR_NAME_SIZE, "S0.%.26snm", number);
}
