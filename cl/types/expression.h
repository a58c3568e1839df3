/* types/expression.h: programs of formulas: short instructions over registers, the same for all lanes.
 *
 * In a medium's table an instruction is CPM_INSTRUCTION doubles: its operation and registers as bits, eight each from
 * the lowest (operation, target, a, b, c), then the constants k and l. Numbers are those of cpm/medium.h. */
#ifndef CPM_TYPES_EXPRESSION_H
#define CPM_TYPES_EXPRESSION_H
#include "../dialect.h"

#define CPM_INSTRUCTION 3
#define CPM_REGISTERS 128

/* Registers that hold something at the start. */
#define CPM_REGISTER_X 0
#define CPM_REGISTER_Y 1
#define CPM_REGISTER_Z 2
#define CPM_REGISTER_R 3          /* |r|; only where the program says that it reads it */
#define CPM_REGISTER_WAVELENGTH 4 /* nm; the same */
#define CPM_FIRST_REGISTER 5

#define CPM_OP_CONSTANT 1     /* k */
#define CPM_OP_ADD 2          /* a + b */
#define CPM_OP_SUBTRACT 3     /* a - b */
#define CPM_OP_MULTIPLY 4     /* a b */
#define CPM_OP_DIVIDE 5       /* a/b */
#define CPM_OP_SCALE 6        /* k a */
#define CPM_OP_AFFINE 7       /* k a + l */
#define CPM_OP_MULTIPLY_ADD 8 /* a b + c */
#define CPM_OP_INVERT 9       /* k/a */
#define CPM_OP_SQRT 20
#define CPM_OP_EXP 21
#define CPM_OP_LOG 22
#define CPM_OP_SIN 23
#define CPM_OP_COS 24
#define CPM_OP_TAN 25
#define CPM_OP_ASIN 26
#define CPM_OP_ACOS 27
#define CPM_OP_ATAN2 28 /* of a over b */
#define CPM_OP_SINH 29
#define CPM_OP_COSH 30
#define CPM_OP_TANH 31
#define CPM_OP_ABS 32
#define CPM_OP_MIN 33
#define CPM_OP_MAX 34
#define CPM_OP_SIGN 35  /* -1, 0, 1 */
#define CPM_OP_LESS 36  /* 1 where a < b, else 0 */
#define CPM_OP_POWER 37 /* a^b, a >= 0 */

/* cpm_medium_data.size[2] of a formula. */
#define CPM_READS_R 1
#define CPM_READS_WAVELENGTH 2
#endif
