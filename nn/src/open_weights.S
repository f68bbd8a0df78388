// The files of open_weights/ as they are, carried in the library's read-only data. Their paths come
// from the build.

#ifdef __APPLE__
#define SYMBOL(name) _##name
    .const_data
#else
#define SYMBOL(name) name
    .section .rodata
#endif

    .globl SYMBOL(gluevo_open_superpoint_begin)
    .globl SYMBOL(gluevo_open_superpoint_end)
    .globl SYMBOL(gluevo_open_superglue_begin)
    .globl SYMBOL(gluevo_open_superglue_end)

    .balign 64
SYMBOL(gluevo_open_superpoint_begin):
    .incbin GLUEVO_OPEN_SUPERPOINT
SYMBOL(gluevo_open_superpoint_end):

    .balign 64
SYMBOL(gluevo_open_superglue_begin):
    .incbin GLUEVO_OPEN_SUPERGLUE
SYMBOL(gluevo_open_superglue_end):

#if defined(__linux__) && defined(__ELF__)
    .section .note.GNU-stack, "", %progbits
#endif
