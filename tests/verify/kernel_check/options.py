"""options.py SCOTTY: what `scotty check` is asked for on its command line, each option seen to work and to fail."""
import json
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

SCOTTY = os.path.abspath(sys.argv[1])
problems = []


def write(name, text):
    os.makedirs(os.path.dirname(name) or ".", exist_ok=True)
    with open(name, "w", encoding="utf-8") as file:
        file.write(text)


def check(words, code, *patterns, environment=None):
    """Runs scotty check; its exit code and what it says, on both streams, must be as expected."""
    ran = subprocess.run([SCOTTY, "check"] + words, capture_output=True, text=True, check=False, env=environment)
    said = ran.stdout + ran.stderr
    name = "scotty check " + " ".join(words)
    if ran.returncode != code:
        problems.append(f"{name}: expected exit code {code}, found {ran.returncode}:\n{said}")
    for pattern in patterns:
        if not re.search(pattern, said, re.S):
            problems.append(f"{name}: expected '{pattern}' in:\n{said}")
    return ran.stdout


SOUND = """
__global__ void k(int* a) { a[threadIdx.x] = threadIdx.x; }
int main() {
    int* a = nullptr;
    cudaMalloc(&a, 64 * sizeof(int));
    k<<<1, 64>>>(a);
    cudaFree(a);
}
"""


def main():
    # Headers of the system and of the project, definitions, the standard.
    write("include/mine.h", "#pragma once\n#ifndef SIZE\n#error no SIZE\n#endif\n")
    write("headers.cu", "#include <mine.h>\n#include <algorithm>\n#include <filesystem>\n#include <functional>\n#include <map>\n"
          "#include <memory>\n#include <random>\n#include <string>\n#include <thread>\n"
          "static_assert(SIZE == 64);\n" + SOUND)
    check(["headers.cu", "-I", "include", "-D", "SIZE=64"], 0, "passed, 0 findings")
    check(["headers.cu", "-D", "SIZE=64"], 2, "mine.h: No such file")
    check(["headers.cu", "-I", "include"], 2, "no SIZE")
    write("standard.cu", "template <class T> concept Small = sizeof(T) <= 4;\ntemplate <Small T> struct Box { T value; };\n"
          "Box<int> box;\n" + SOUND)
    check(["standard.cu", "--std", "c++20"], 0, "passed")
    check(["standard.cu"], 2, "does not compile")

    # Several files, one of them plain; what stands behind -- is the program's.
    write("kernel.cu", '#include "shared.h"\n__device__ int offset = 5;\n__global__ void k(int* a) { a[threadIdx.x] = twice(offset); }\n')
    write("shared.h", "#pragma once\n__device__ int twice(int x);\n__global__ void k(int* a);\n")
    write("device.cu", '#include "shared.h"\n__device__ int twice(int x) { return 2 * x; }\n')
    write("main.cpp", '#include "shared.h"\n#include <cstdlib>\n#include <cstring>\nint main(int count, char** words) {\n'
          "    if (count != 3 || std::strcmp(words[2], \"--loud\") != 0) return 9;\n    int* a = nullptr;\n"
          "    int got = 0;\n    cudaMalloc(&a, 4 * std::atoi(words[1]));\n    k<<<1, 64>>>(a);\n"
          "    cudaMemcpy(&got, a, 4, cudaMemcpyDeviceToHost);\n    cudaFree(a);\n    return got == 10 ? 0 : 8;\n}\n")
    check(["kernel.cu", "device.cu", "main.cpp", "--", "64", "--loud"], 0, "passed")
    check(["kernel.cu", "device.cu", "main.cpp", "--", "32", "--loud"], 1, "out of bounds: .*kernel.cu:3")
    check(["kernel.cu", "device.cu", "main.cpp"], 1, "ended with exit code 9")
    check(["kernel.cu", "main.cpp"], 2, "is not linked|undefined reference")
    check(["kernel.cu", "64"], 2, "expected a source file")

    # Warnings, and what only --strict finds.
    write("same.cu", "__global__ void k(int* a) { *a = 7; }\nint main() {\n    int* a = nullptr;\n    cudaMalloc(&a, 4);\n"
          "    k<<<1, 64>>>(a);\n    cudaFree(a);\n}\n")
    check(["same.cu"], 0, "warning: same-value race: .*same.cu:1")
    check(["same.cu", "--strict"], 1, "same-value race: .*FAILED")
    write("early.cu", "__global__ void k(int* a) {\n    if (threadIdx.x >= 32) return;\n    __syncthreads();\n    a[threadIdx.x] = 1;\n}\n")
    check(["early.cu", "--launch", "k<<<1, 64>>>(int[64])"], 0, "passed")
    check(["early.cu", "--launch", "k<<<1, 64>>>(int[64])", "--strict"], 1, "divergence: .*early.cu:3")

    # Leaks, misaligned accesses, launches that fail.
    write("leak.cu", "int main() {\n    int* a = nullptr;\n    cudaMalloc(&a, 44);\n    cudaMalloc(&a, 4);\n    cudaFree(a);\n}\n")
    check(["leak.cu"], 0, "warning: leak: 44 bytes are never freed.*leak.cu:3")
    check(["leak.cu", "--strict"], 1, "leak: 44 bytes")
    write("misaligned.cu", "__global__ void k(char* a) { *reinterpret_cast<int*>(a + 2) = 1; }\n")
    check(["misaligned.cu", "--launch", "k<<<1, 1>>>(char[64])"], 1, "misaligned: .*misaligned.cu:1")
    write("launch.cu", "#include <cstdio>\n__global__ void k() {}\nint main() {\n    k<<<1, 2048>>>();\n"
          "    return cudaGetLastError() == cudaErrorInvalidConfiguration ? 0 : 5;\n}\n")
    check(["launch.cu"], 1, "launch failed: .*1 to 1024 threads.*launch.cu:4")

    # Reports for programs.
    write("two.cu", "__global__ void k(int* a) {\n    __shared__ int s[64];\n    s[threadIdx.x] = 1;\n    a[threadIdx.x] = s[63 - threadIdx.x];\n"
          "    a[64 + threadIdx.x] = 1;\n}\n")
    launch = ["two.cu", "--launch", "k<<<1, 64>>>(int[64])", "--schedules", "3"]
    said = json.loads(check(launch + ["--json", "--junit", "two.xml"], 1))
    kinds = sorted({finding["kind"] for finding in said["findings"]})
    if kinds[:2] != ["data race", "out of bounds"] or said["verdict"] != "failed" or len(said["schedules"]) != 3:
        problems.append(f"--json: {said}")
    suite = next(xml.etree.ElementTree.parse("two.xml").iter("testsuite"))
    failures = [element.get("message", "") + (element.text or "") for element in suite.iter("failure")]
    if int(suite.get("failures", 0)) < 1 or not any("two.cu:4" in failure for failure in failures):
        problems.append(f"--junit: {suite.attrib} {failures}")
    check(["headers.cu", "-I", "include", "-D", "SIZE=64", "--junit", "sound.xml"], 0)
    suite = next(xml.etree.ElementTree.parse("sound.xml").iter("testsuite"))
    if suite.get("failures") != "0" or suite.get("tests") != "1" or list(suite.iter("failure")):
        problems.append(f"--junit of a sound program: {suite.attrib}")
    check(["two.cu", "--junit", "no/such/folder.xml", "--launch", "k<<<1, 64>>>(int[64])"], 2, "folder.xml")

    # No compiler.
    os.makedirs("empty", exist_ok=True)
    bare = {name: value for name, value in os.environ.items() if name != "CXX"}
    check(["same.cu"], 3, "there is none: neither", environment=dict(bare, PATH=os.path.abspath("empty")))
    check(["same.cu", "--compiler", "no-such-compiler"], 3, "no-such-compiler")
    check(["no_such.cu"], 2, "there is no such file")

    print("\n".join(problems) if problems else "every option does what it says")
    return 1 if problems else 0


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    sys.exit(main())
