# The packed art, as read-only bytes. PROCGEN_ART_BLOB is the file that pack.py wrote.
    .section .rodata
    .global procgen_art_blob
    .balign 16
procgen_art_blob:
    .incbin PROCGEN_ART_BLOB
    .section .note.GNU-stack,"",%progbits
