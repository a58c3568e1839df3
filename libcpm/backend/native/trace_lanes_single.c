/* backend/native/trace_lanes_single.c: trace_lanes.c with lanes of float. */
#define CPM_SINGLE 1
#include "trace_lanes.c"
