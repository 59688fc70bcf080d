"""Files that somebody else made: what is checked before a library may read them.

One scheme for databases, pictures and vector files:

1. The schema or header is read first, by our own code, and compared with what an honest program
   writes (`databases`, `picture_headers`).
2. What reading will take is compared with a budget that follows from the size of the file and the
   free memory (`budgets`).
3. A library that cannot be interrupted reads in a process that can be ended (`reader_process`).

A refusal is an `InputError` whose code is in the catalogue of findings: ``file.unsafe-schema``,
``file.picture-too-large``, ``file.picture-header``, ``file.memory-exceeded``.
"""
