// The files of open_weights/ as they are, carried in the library's read-only data. Their paths come
// from the build.

    .section .rodata

    .globl gluevo_open_superpoint_begin
    .globl gluevo_open_superpoint_end
    .globl gluevo_open_superglue_begin
    .globl gluevo_open_superglue_end
    .globl gluevo_open_places_begin
    .globl gluevo_open_places_end

    .balign 64
gluevo_open_superpoint_begin:
    .incbin GLUEVO_OPEN_SUPERPOINT
gluevo_open_superpoint_end:

    .balign 64
gluevo_open_superglue_begin:
    .incbin GLUEVO_OPEN_SUPERGLUE
gluevo_open_superglue_end:

    .balign 64
gluevo_open_places_begin:
    .incbin GLUEVO_OPEN_PLACES
gluevo_open_places_end:

    .section .note.GNU-stack, "", %progbits
