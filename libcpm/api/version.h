/* api/version.h: the version as text, from the numbers of the public header. Internal. */
#ifndef CPM_API_VERSION_H
#define CPM_API_VERSION_H
#include "cpm/context.h"

#define CPM_TEXT_OF_(x) #x
#define CPM_TEXT_OF(x) CPM_TEXT_OF_(x)
#define CPM_VERSION_TEXT                                                                                               \
    CPM_TEXT_OF(CPM_VERSION_MAJOR) "." CPM_TEXT_OF(CPM_VERSION_MINOR) "." CPM_TEXT_OF(CPM_VERSION_PATCH)
#endif
