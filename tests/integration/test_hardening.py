"""How the programs are linked and compiled, read from their ELF headers."""
import re
import subprocess
import unittest

from harness import BIN

PROGRAMS = ("vacuform", "vacuform-server", "vacuform-worker")


def read_elf(option, program):
    return subprocess.run(["readelf", "-W", option, BIN / program], check=True, capture_output=True, text=True).stdout


def hardened(program):
    """The measures that a program has."""
    header, segments, dynamic = (read_elf(o, program) for o in ("-h", "-l", "-d"))
    symbols = read_elf("--dyn-syms", program)
    main = subprocess.run(["objdump", "-d", "--disassemble=main", BIN / program], check=True, capture_output=True,
                          text=True).stdout
    return {
        "runs at any address": "Type:                              DYN" in header,
        "read-only after linking": "GNU_RELRO" in segments and "BIND_NOW" in dynamic,
        "no executable stack": re.search(r"GNU_STACK .* RW ", segments) is not None,
        "stack protector": "__stack_chk_fail" in symbols,
        "checked calls of the C library": re.search(r"__\w+_chk@", symbols.replace("__stack_chk_fail", "")) is not None,
        "checked containers": "_ZSt21__glibcxx_assert_fail" in symbols,
        "marked targets of jumps": "X86-64" not in header or "endbr64" in main,
    }


class Hardening(unittest.TestCase):
    def test_every_program_has_every_measure(self):
        for program in PROGRAMS:
            for measure, there in hardened(program).items():
                with self.subTest(program=program, measure=measure):
                    self.assertTrue(there)


if __name__ == "__main__":
    unittest.main()
