"""Checks of files from unknown sources before a library reads them.

One scheme for databases, pictures and vector files:

1. The schema or header is parsed first, by code of this program, and compared with valid
   files (`databases`, `picture_headers`).
2. The memory that reading needs is compared with a budget, computed from the size of the file and
   the free memory (`budgets`).
3. A library that cannot be interrupted runs in a separate process that can be terminated
   (`reader_process`).

A rejected file raises an `InputError` with a code of the catalogue of findings:
``file.unsafe-schema``, ``file.picture-too-large``, ``file.picture-header``,
``file.memory-exceeded``.
"""
