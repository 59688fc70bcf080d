"""The Python interface: what `import vomstudio as vs` offers, a module for each part of it.

`vomstudio/__init__.py` names the modules as text and imports one where something of it is asked
for. Whoever asks first brings the language of the user.
"""

from vomstudio.core.languages import use_user_language

use_user_language()
