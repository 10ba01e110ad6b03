"""Another process that acts between two calls to the system, whichever they are."""

import sys

#: What Python says before it asks the system for something about a file.
EVENTS = {"open", "os.remove", "os.rename", "os.link", "os.mkdir", "os.rmdir", "os.listdir", "os.scandir",
          "os.truncate", "os.utime", "os.chmod", "shutil.rmtree"}  # fmt: skip
_watch = []


def _heard(event, arguments):
    if _watch and event in EVENTS and not str(arguments[0]).endswith((".py", ".pyc")):
        _watch[-1]()


sys.addaudithook(_heard)


def at_call(number, act, during):
    """Do something before the call of that number; return how many there were, or None if it was done."""
    calls = [0]

    def counted():
        calls[0] += 1
        if calls[0] == number:
            _watch.clear()  # what is done now is no call of theirs
            act()

    _watch.append(counted)
    try:
        during()
    finally:
        _watch.clear()
    return None if calls[0] >= number else calls[0]
