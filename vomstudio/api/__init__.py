"""Python interface: the names of `import vomstudio as vs`, one module for each subject.

`vomstudio/__init__.py` lists the modules as text, and imports a module when one of its names is
used. The import of this package selects the language of the user.
"""

from vomstudio.core.languages import use_user_language

use_user_language()
