/* medium/catalogue.c: published dispersions by name. */
#include <ctype.h>
#include <string.h>

#include "catalogue_data.h"

#define LONGEST 32

/* Lower case without blanks, hyphens and underscores; 0: longer than any name. */
static int fold(const char *name, char folded[LONGEST]) {
    size_t length = 0;
    for (; *name; name++) {
        if (*name == ' ' || *name == '-' || *name == '_') continue;
        if (length + 1 == LONGEST) return 0;
        folded[length++] = (char)tolower((unsigned char)*name);
    }
    folded[length] = '\0';
    return 1;
}

cpm_status cpm_dispersion_catalogue(cpm_context *context, const char *name, cpm_dispersion *dispersion) {
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!name || !dispersion)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "%s is NULL", name ? "dispersion" : "name");
    if (dispersion->struct_size < sizeof *dispersion)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "dispersion.struct_size is %zu; set it to sizeof(cpm_dispersion)", dispersion->struct_size);
    char folded[LONGEST];
    const size_t count = sizeof published / sizeof *published;
    for (size_t i = 0; i < count && fold(name, folded); i++)
        for (size_t k = 0; k < 4 && published[i].names[k]; k++) {
            if (strcmp(folded, published[i].names[k])) continue;
            const size_t size = dispersion->struct_size;
            memset(dispersion, 0, sizeof *dispersion);
            dispersion->struct_size = size;
            dispersion->kind = published[i].kind;
            dispersion->count = published[i].count;
            memcpy(dispersion->coefficients, published[i].coefficients, sizeof published[i].coefficients);
            dispersion->low = published[i].low, dispersion->high = published[i].high;
            return CPM_OK;
        }
    char known[256] = "";
    for (size_t i = 0; i < count; i++) {
        if (i) strncat(known, ", ", sizeof known - strlen(known) - 1);
        strncat(known, published[i].label, sizeof known - strlen(known) - 1);
    }
    return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "name is \"%.40s\"; %s are in the catalogue", name, known);
}
