/* Compiled as C and as C++: the whole public interface can be included, and every function of it linked. */
#include <cpm/cpm.h>
#include <stdio.h>
#include <string.h>

typedef void (*any_function)(void);

/* The address of each public function: one missing from the library fails the link. */
static const any_function functions[] = {
#define F(name) (any_function) name,
#include "public_functions.inc"
#undef F
};

int main(void) {
    size_t count = 0;
    for (size_t i = 0; i < sizeof functions / sizeof *functions; i++) count += functions[i] != NULL;
    cpm_context *context = NULL;
    if (cpm_context_create(NULL, &context) != CPM_OK) return 1;
    cpm_context_release(context);
    printf("libcpm %s (%s): %d functions\n", cpm_version(), cpm_build_info(), (int)count);
    return strcmp(cpm_status_string(CPM_OK), "no error") != 0;
}
