/* api/status.c: texts of the status codes, from the same lists as the enums. */
#include "cpm/status.h"

const char *cpm_status_string(cpm_status status) {
    switch (status) {
#define CASE(name, value, text)                                                                                        \
    case name: return text;
        CPM_STATUS_LIST(CASE)
    }
    return "unknown status";
}

const char *cpm_ray_status_string(cpm_ray_status status) {
    switch (status) {
        CPM_RAY_STATUS_LIST(CASE)
#undef CASE
    }
    return "unknown status";
}
