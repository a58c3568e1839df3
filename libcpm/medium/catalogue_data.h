/* clang-format off */
/* medium/catalogue_data.h: made by spectral/generate_catalogue.py from spectral/data/dispersion.toml, which
 * has the sources. Names folded: lower case, no blanks, hyphens or underscores; after the first, aliases. */
#include "dispersion.h"

static const struct {
    const char *names[4];
    const char *label;
    int32_t kind, count;
    double coefficients[8];
    double low, high;
} published[] = {
    {{"bk7", "nbk7"},
     "BK7",
     CPM_DISPERSION_SELLMEIER,
     6,
     {1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653},
     300.0,
     2500.0},
    {{"f2"},
     "F2",
     CPM_DISPERSION_SELLMEIER,
     6,
     {1.34533359, 0.00997743871, 0.209073176, 0.0470450767, 0.937357162, 111.886764},
     320.0,
     2500.0},
    {{"sf11"},
     "SF11",
     CPM_DISPERSION_SELLMEIER,
     6,
     {1.73848403, 0.0136068604, 0.311168974, 0.0615960463, 1.17490871, 121.922711},
     390.0,
     2500.0},
    {{"fusedsilica", "silica", "sio2"},
     "fused silica",
     CPM_DISPERSION_SELLMEIER,
     6,
     {0.6961663, 0.00467914825849, 0.4079426, 0.013512063073959999, 0.8974794, 97.93400253792099},
     210.0,
     3710.0},
    {{"water", "h2o"},
     "water",
     CPM_DISPERSION_SELLMEIER,
     8,
     {0.5684027565, 0.005101829712, 0.1726177391, 0.01821153936, 0.02086189578, 0.02620722293, 0.1130748688, 10.69792721},
     182.0,
     1129.0},
    {{"sapphire", "al2o3"},
     "sapphire",
     CPM_DISPERSION_SELLMEIER,
     6,
     {1.4313493, 0.005279926101609999, 0.65054713, 0.014238264705640002, 5.3414021, 325.017834119001},
     200.0,
     5000.0},
    {{"diamond"},
     "diamond",
     CPM_DISPERSION_SELLMEIER,
     4,
     {0.3306, 0.030624999999999996, 4.3356, 0.011236},
     226.0,
     760.0},
    {{"air"},
     "air",
     CPM_DISPERSION_GAS,
     8,
     {0.0, 0.0, 0.0, 0.0, 0.05792105, 238.0185, 0.00167917, 57.362},
     230.0,
     1690.0},
};
