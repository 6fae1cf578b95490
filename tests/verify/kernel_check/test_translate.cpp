/// From CUDA text to C++ text: what is changed, what is not, and what is refused.
#include <algorithm>
#include <string>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "verify/kernel_check/kernel_check.h"
#include "verify/kernel_check/translate.h"

using Catch::Matchers::ContainsSubstring;
using scotty::verify::CopiesOfRecords;
using scotty::verify::main_of_launch;
using scotty::verify::translate_cuda;

namespace {

std::string complaint_about(const std::string& text) {
    try {
        translate_cuda(text);
    } catch (const scotty::reference::Error& error) {
        CHECK(error.kind() == scotty::reference::ErrorKind::bad_input);
        return error.what();
    }
    return "nothing";
}

}  // namespace

TEST_CASE("translate: a launch becomes a call", "[verify][check]") {
    const std::string text = translate_cuda(
        "__global__ void k(int* a) {}\n"
        "void f() { k<<<dim3(1, 2), 32>>>(nullptr); }\n");
    CHECK_THAT(text, !ContainsSubstring("<<<") && !ContainsSubstring("__global__"));
    CHECK_THAT(text, ContainsSubstring("launcher(\"k\", k, ::scotty_cuda::Config(dim3(1, 2), 32))"
                                       "(nullptr)"));
}

TEST_CASE("translate: a template is launched by name", "[verify][check]") {
    const std::string text = translate_cuda(
        "template <class T> __global__ void k(T* a) {}\n"
        "void f(int* a) { k<int><<<1, 32>>>(a); }\n");
    CHECK_THAT(text, ContainsSubstring("generic_launcher(\"k<int>\""));
}

TEST_CASE("translate: shared variables become references", "[verify][check]") {
    const std::string text = translate_cuda(
        "__global__ void k() { __shared__ volatile float a[2][3], b; extern __shared__ int c[]; "
        "}\n");
    CHECK_THAT(text, !ContainsSubstring("__shared__"));
    CHECK_THAT(text, ContainsSubstring("typedef volatile float  scotty_type_a_0[2][3];"));
    CHECK_THAT(text, ContainsSubstring("& b = ::scotty_cuda::shared<"));
    CHECK_THAT(text, ContainsSubstring("* const c = "));
}

TEST_CASE("translate: variables of the device are registered, functions are not",
          "[verify][check]") {
    const std::string text = translate_cuda(
        "__device__ int a[4] = {1}, b;\n"
        "__constant__ float c;\n"
        "__device__ int f(int x) { return x; }\n"
        "extern __device__ int d;\n");
    CHECK_THAT(text, ContainsSubstring("(&a, sizeof(a), \"a\", ::scotty_cuda::Space::device)"));
    CHECK_THAT(text, ContainsSubstring("(&b, "));
    CHECK_THAT(text, ContainsSubstring("\"c\", ::scotty_cuda::Space::constant"));
    CHECK_THAT(text, !ContainsSubstring("&f") && !ContainsSubstring("&d,"));
}

TEST_CASE("translate: a kernel's returns announce themselves, a lambda's do not",
          "[verify][check]") {
    const std::string text = translate_cuda(
        "__global__ void k(int n) {\n"
        "    if (n) return;\n"
        "    auto f = [&](int i) { if (i) return; };\n"
        "}\n"
        "void host() { return; }\n");
    CHECK_THAT(text, ContainsSubstring("return ::scotty_cuda::leave(\"\", 1);") ||
                         ContainsSubstring("return ::scotty_cuda::leave(\"\", 2);"));
    CHECK_THAT(text, ContainsSubstring("if (i) return; }"));
    CHECK_THAT(text, ContainsSubstring("void host() { return; }"));
}

TEST_CASE("translate: lines stay where they are", "[verify][check]") {
    const std::string text =
        "__global__ void k() {\n"
        "    __shared__ int a[4],\n"
        "        b;\n"
        "    a[0] = 1;\n"
        "}\n"
        "void f() {\n"
        "    k<<<1,\n"
        "        2>>>();\n"
        "}\n";
    const std::string out = translate_cuda(text);
    CHECK(std::count(out.begin(), out.end(), '\n') == std::count(text.begin(), text.end(), '\n'));
}

TEST_CASE("translate: text in strings and of the system stays as it is", "[verify][check]") {
    const std::string text =
        "const char* s = \"k<<<1, 2>>>()\";\n"
        "# 1 \"/usr/include/x.h\" 1 3\n"
        "int __shared__;\n"
        "# 3 \"a.cu\" 2\n";
    CHECK(translate_cuda(text) == text);
}

TEST_CASE("translate: what is not supported is refused by file, line and name", "[verify][check]") {
    const std::string begin = "# 1 \"a.cu\"\n\n";
    for (const char* word : {"asm(\"\");", "cudaTextureObject_t t;", "int x = __shfl(1, 2);",
                             "cudaGraph_t g;", "__half h;"}) {
        const std::string complaint = complaint_about(begin + word);
        CHECK_THAT(complaint, ContainsSubstring("a.cu:2: '"));
        CHECK_THAT(complaint, ContainsSubstring("is not supported"));
    }
    CHECK_THAT(complaint_about("__global__ void k() { k<<<1, 1>>>(); }"),
               ContainsSubstring("dynamic parallelism"));
    CHECK_THAT(complaint_about("__shared__ int a;"), ContainsSubstring("outside of functions"));
}

TEST_CASE("translate: every record gets a last member that makes its copies seen",
          "[verify][check]") {
    const auto member = [](const std::string& of) {
        return " public: [[no_unique_address]] ::scotty_cuda::Copied<" + of + "> scotty_copied; }";
    };
    CHECK(translate_cuda("struct A { int x; };") == "struct A { int x;" + member("A") + ";");
    CHECK(translate_cuda("template <class T> class alignas(8) B final : C<T> { struct D { }; };") ==
          "template <class T> class alignas(8) B final : C<T> { struct D {" + member("D") + ";" +
              member("B") + ";");
    CHECK(translate_cuda("typedef struct { int x; } F;") ==
          "typedef struct scotty_record_0 { int x;" + member("scotty_record_0") + " F;");
    for (const char* const same : {"struct A; struct A* p; struct A a{1}; struct A f(); enum class "
                                   "E { a }; union U { struct { int x, y; }; int z; };",
                                   "template <class T, struct S> void f(class G* g);"}) {
        CHECK(translate_cuda(same) == same);
    }
    const std::string plain = "struct A { int x; };";
    CHECK(translate_cuda(plain, CopiesOfRecords::unseen) == plain);
}

TEST_CASE("check: --launch makes a main", "[verify][check]") {
    const std::string text = main_of_launch("k<<<2, 32>>>(float[64], 7, int[4])");
    CHECK_THAT(text, ContainsSubstring("filled<float>(64)") && ContainsSubstring("filled<int>(4)"));
    CHECK_THAT(text, ContainsSubstring("k<<<2, 32>>>(scotty_array_0, 7, scotty_array_1);"));
    CHECK_THROWS_AS(main_of_launch("k(1)"), scotty::reference::Error);
}
