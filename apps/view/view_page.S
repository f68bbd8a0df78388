// page.html as it is, carried in the program's read-only data. Its path comes from the build.

    .section .rodata

    .globl gluevo_view_page_begin
    .globl gluevo_view_page_end

gluevo_view_page_begin:
    .incbin GLUEVO_VIEW_PAGE
gluevo_view_page_end:

    .section .note.GNU-stack, "", %progbits
