"""Print pip's configuration as shell assignments of uv's environment variables; uv does not read it itself."""

import os
import shlex
import subprocess
import sys

NAMES = {
    "index-url": "UV_DEFAULT_INDEX",
    "extra-index-url": "UV_INDEX",
    "find-links": "UV_FIND_LINKS",
    "cert": "SSL_CERT_FILE",
}
SECTIONS = ("global", "install", ":env:")

listed = subprocess.run([sys.executable, "-m", "pip", "config", "list"], capture_output=True, text=True, check=True)
for line in listed.stdout.splitlines():
    name, _, value = line.partition("=")
    section, _, key = name.rpartition(".")
    variable = NAMES.get(key)
    if variable and section in SECTIONS and variable not in os.environ:
        values = value.strip("'\"").replace("\\n", " ").split()
        print(f"export {variable}={shlex.quote((',' if key == 'find-links' else ' ').join(values))}")
