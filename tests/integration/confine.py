"""Starts a program under a seccomp filter, as a machine with less than ours would: by libseccomp, through ctypes."""
import ctypes
import errno
import os
import pathlib
import re
import subprocess

ALLOW, ERRNO = 0x7FFF0000, 0x00050000
UNIT = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "units" / "vacuform-worker@.service"
NAMESPACES = {"mnt": 0x00020000, "cgroup": 0x02000000, "uts": 0x04000000, "ipc": 0x08000000, "user": 0x10000000, "pid": 0x20000000,
              "net": 0x40000000}


class Argument(ctypes.Structure):
    _fields_ = [("number", ctypes.c_uint), ("comparison", ctypes.c_int), ("a", ctypes.c_uint64), ("b", ctypes.c_uint64)]


class Filter:
    """A filter made in this process and loaded into a child, between fork and exec."""

    def __init__(self, default=ALLOW):
        self.library = ctypes.CDLL("libseccomp.so.2", use_errno=True)
        self.library.seccomp_init.restype = ctypes.c_void_p
        self.context = ctypes.c_void_p(self.library.seccomp_init(ctypes.c_uint32(default)))

    def add(self, action, call, *arguments):
        """`arguments` are (number, mask, value): the rule holds where the argument under the mask is the value."""
        number = call if isinstance(call, int) else self.library.seccomp_syscall_resolve_name(call.encode())
        if number < 0 and isinstance(call, str):
            return
        array = (Argument * len(arguments))(*(Argument(n, 7, mask, value) for n, mask, value in arguments))
        done = self.library.seccomp_rule_add_array(self.context, ctypes.c_uint32(action), number, len(arguments), array)
        assert done in (0, -errno.EEXIST), (call, done)

    def load(self):
        ctypes.CDLL(None).prctl(38, 1, 0, 0, 0)  # no new privileges
        if self.library.seccomp_load(self.context) != 0:
            os._exit(125)


def without_landlock():
    """A kernel without Landlock."""
    made = Filter()
    for number in 444, 445, 446:
        made.add(ERRNO | errno.ENOSYS, number)
    return made


def without_namespaces():
    """A container that gives no namespaces, as Docker's does."""
    made = Filter()
    for flag in NAMESPACES.values():
        made.add(ERRNO | errno.EPERM, "clone", (0, flag, flag))
        made.add(ERRNO | errno.EPERM, "unshare", (0, flag, flag))
    made.add(ERRNO | errno.ENOSYS, "clone3")
    return made


def calls_of(group):
    """The calls of a group of systemd's."""
    listed = subprocess.run(["systemd-analyze", "syscall-filter", group], capture_output=True, text=True, check=True).stdout
    names = []
    for line in listed.splitlines():
        name = line.strip()
        if name.startswith("@") and name != group:
            names += calls_of(name)
        elif re.fullmatch(r"[a-z0-9_]+", name):
            names.append(name)
    return names


def as_the_unit_allows():
    """The calls that the worker's unit leaves: SystemCallFilter, RestrictNamespaces, RestrictSUIDSGID."""
    text = UNIT.read_text()
    allowed, refused = set(), set()
    for words in re.findall(r"^SystemCallFilter=(.*)$", text, re.M):
        into = refused if words.startswith("~") else allowed
        for word in words.lstrip("~").split():
            into.update(calls_of(word) if word.startswith("@") else [word])
    given = re.search(r"^RestrictNamespaces=(.*)$", text, re.M)[1].split()
    made = Filter(ERRNO | errno.EPERM)
    withheld = sum(flag for name, flag in NAMESPACES.items() if name not in given)
    for call in allowed - refused - {"clone3", "openat2", "clone", "unshare"}:
        made.add(ALLOW, call)
    for call in "clone", "unshare":
        made.add(ALLOW, call, (0, withheld, 0))
    made.add(ERRNO | errno.ENOSYS, "clone3")
    assert "\nRestrictSUIDSGID=yes\n" in text
    made.add(ERRNO | errno.ENOSYS, "openat2")
    return made
