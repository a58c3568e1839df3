/* medium/expression.c: a formula's program: checked so that nothing it says can harm, then packed into the table. */
#include "cl/types/expression.h"

#include <math.h>
#include <string.h>

#include "dispersion.h"

/* Which registers an operation takes: bits for a, b, c. -1: no such operation. */
static int operands(int32_t operation) {
    switch (operation) {
    case CPM_OPERATION_CONSTANT: return 0;
    case CPM_OPERATION_ADD:
    case CPM_OPERATION_SUBTRACT:
    case CPM_OPERATION_MULTIPLY:
    case CPM_OPERATION_DIVIDE:
    case CPM_OPERATION_ATAN2:
    case CPM_OPERATION_MIN:
    case CPM_OPERATION_MAX:
    case CPM_OPERATION_LESS:
    case CPM_OPERATION_POWER: return 3;
    case CPM_OPERATION_MULTIPLY_ADD: return 7;
    case CPM_OPERATION_SCALE:
    case CPM_OPERATION_AFFINE:
    case CPM_OPERATION_INVERT: return 1;
    default: return operation >= CPM_OPERATION_SQRT && operation <= CPM_OPERATION_SIGN ? 1 : -1;
    }
}

typedef struct reader {
    cpm_context *context;
    uint8_t known[CPM_REGISTERS]; /* holds a value */
    int reads;                    /* CPM_READS_ */
} reader;

static cpm_status read_register(reader *r, const char *place, size_t i, int32_t number) {
    if (number < 0 || number >= CPM_REGISTERS || !r->known[number])
        return cpm_fail(r->context, CPM_ERROR_INVALID_ARGUMENT,
                        "%s %zu reads register %d; must be 0 to 4, or one of 5 to %d that was written before", place, i,
                        (int)number, CPM_REGISTERS - 1);
    if (number == CPM_REGISTER_R) r->reads |= CPM_READS_R;
    if (number == CPM_REGISTER_WAVELENGTH) r->reads |= CPM_READS_WAVELENGTH;
    return CPM_OK;
}

static cpm_status check_instruction(reader *r, const cpm_instruction *in, size_t i) {
    int takes = operands(in->operation);
    if (takes < 0)
        return cpm_fail(r->context, CPM_ERROR_INVALID_ARGUMENT,
                        "instruction %zu has operation %d; must be one of cpm_operation", i, (int)in->operation);
    const int32_t from[3] = {in->a, in->b, in->c};
    for (int k = 0; k < 3; k++) {
        cpm_status status = takes >> k & 1 ? read_register(r, "instruction", i, from[k]) : CPM_OK;
        if (status != CPM_OK) return status;
    }
    if (in->target < CPM_FIRST_REGISTER || in->target >= CPM_REGISTERS)
        return cpm_fail(r->context, CPM_ERROR_INVALID_ARGUMENT, "instruction %zu writes register %d; must be %d to %d",
                        i, (int)in->target, CPM_FIRST_REGISTER, CPM_REGISTERS - 1);
    if (!isfinite(in->k) || !isfinite(in->l))
        return cpm_fail(r->context, CPM_ERROR_INVALID_ARGUMENT, "instruction %zu has constants %g and %g; must be finite",
                        i, in->k, in->l);
    r->known[in->target] = 1;
    return CPM_OK;
}

static void pack(const cpm_instruction *in, double *out) {
    const int takes = operands(in->operation);
    uint64_t code = (uint64_t)in->operation | (uint64_t)in->target << 8;
    if (takes & 1) code |= (uint64_t)in->a << 16;
    if (takes & 2) code |= (uint64_t)in->b << 24;
    if (takes & 4) code |= (uint64_t)in->c << 32;
    memcpy(out, &code, sizeof code);
    out[1] = in->k, out[2] = in->l;
}

cpm_status cpm_medium_create_expression(cpm_context *context, const cpm_expression_desc *desc,
                                        const cpm_dispersion *dispersion, cpm_medium **medium) {
    if (!medium) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "medium is NULL");
    *medium = NULL;
    if (!context) return CPM_ERROR_INVALID_ARGUMENT;
    if (!desc) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "desc is NULL");
    cpm_expression_desc d;
    CPM_TAKE(d, desc);
    if (d.count < 1 || d.count > CPM_MAX_INSTRUCTIONS)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "count is %zu; must be 1 to %d instructions", d.count,
                        CPM_MAX_INSTRUCTIONS);
    if (!d.instructions) return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "instructions is NULL");
    if (!(d.feature >= 0.0) || !isfinite(d.feature))
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT, "feature is %g; must be finite and > 0 metres, or 0",
                        d.feature);
    reader r = {.context = context, .known = {1, 1, 1, 1, 1}};
    cpm_status status = CPM_OK;
    for (size_t i = 0; i < d.count && status == CPM_OK; i++) status = check_instruction(&r, &d.instructions[i], i);
    for (size_t k = 0; k < 4 && status == CPM_OK; k++) status = read_register(&r, "result", k, d.results[k]);
    if (status != CPM_OK) return status;
    if (r.reads & CPM_READS_WAVELENGTH && dispersion && dispersion->kind != CPM_DISPERSION_NONE)
        return cpm_fail(context, CPM_ERROR_INVALID_ARGUMENT,
                        "dispersion is given for a formula that reads the wavelength itself; one of the two is allowed");

    cpm_medium_data data = {.kind = CPM_MEDIUM_EXPRESSION,
                            .size = {(int32_t)d.count, 0, r.reads},
                            .feature = d.feature > 0.0 ? d.feature : INFINITY};
    for (int k = 3; k >= 0; k--) data.size[1] = data.size[1] << 8 | d.results[k];
    status = cpm_medium_make(context, &data, CPM_INSTRUCTION * d.count, dispersion, medium);
    if (status != CPM_OK) return status;
    for (size_t i = 0; i < d.count; i++) pack(&d.instructions[i], (*medium)->table + CPM_INSTRUCTION * i);
    (*medium)->by_wavelength = (r.reads & CPM_READS_WAVELENGTH) != 0;
    (*medium)->dispersive |= (*medium)->by_wavelength;
    return CPM_OK;
}
