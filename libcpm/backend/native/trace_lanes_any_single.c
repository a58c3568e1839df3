/* backend/native/trace_lanes_any_single.c: trace_lanes.c with every medium and lanes of float. */
#define CPM_ANY_MEDIUM 1
#define CPM_SINGLE 1
#include "trace_lanes.c"
