/* backend/native/trace_lanes_any.c: trace_lanes.c with every medium. */
#define CPM_ANY_MEDIUM 1
#include "trace_lanes.c"
