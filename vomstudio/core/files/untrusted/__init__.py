"""Checks of files from unknown sources before a library reads them.

Databases, pictures and vector files are checked in the same way:

1. The schema or header is first parsed by code of this program and compared with that of
   valid files (`databases`, `picture_headers`).
2. The memory needed for reading is compared with a budget, which is computed from the file
   size and the free memory (`budgets`).
3. A library that cannot be interrupted runs in a separate process that can be terminated
   (`reader_process`).

A rejected file raises an `InputError` with a code from the catalogue of findings:
``file.unsafe-schema``, ``file.picture-too-large``, ``file.picture-header``,
``file.memory-exceeded``.
"""
