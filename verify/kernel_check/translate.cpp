#include "verify/kernel_check/translate.h"

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "verify/kernel_check/lexer.h"

namespace scotty::verify {

namespace {

/// Words that stand for what is not supported, and why.
const std::map<std::string_view, const char*>& refused_words() {
    static const std::map<std::string_view, const char*> words = {
        {"__shfl", "CUDA has removed it: use __shfl_sync"},
        {"__shfl_up", "CUDA has removed it: use __shfl_up_sync"},
        {"__shfl_down", "CUDA has removed it: use __shfl_down_sync"},
        {"__shfl_xor", "CUDA has removed it: use __shfl_xor_sync"},
        {"__ballot", "CUDA has removed it: use __ballot_sync"},
        {"__any", "CUDA has removed it: use __any_sync"},
        {"__all", "CUDA has removed it: use __all_sync"},
        {"texture", "textures"},
        {"cudaTextureObject_t", "textures"},
        {"cudaSurfaceObject_t", "surfaces"},
        {"cudaCreateTextureObject", "textures"},
        {"cudaMallocArray", "arrays for textures"},
        {"tex1D", "textures"},
        {"tex1Dfetch", "textures"},
        {"tex2D", "textures"},
        {"tex3D", "textures"},
        {"asm", "PTX inside C++"},
        {"__asm__", "PTX inside C++"},
        {"this_grid", "barriers of a whole grid"},
        {"grid_group", "barriers of a whole grid"},
        {"cudaLaunchCooperativeKernel", "barriers of a whole grid"},
        {"this_cluster", "clusters of blocks"},
        {"__cluster_dims__", "clusters of blocks"},
        {"cudaGraph_t", "graphs"},
        {"cudaStreamBeginCapture", "graphs"},
        {"wmma", "tensor cores"},
        {"__pipeline_memcpy_async", "asynchronous copies"},
        {"memcpy_async", "asynchronous copies"},
        {"__half", "half precision"},
        {"__half2", "half precision"},
        {"half2", "half precision"},
        {"__nv_bfloat16", "bfloat16"},
        {"curandState", "cuRAND"},
        {"curandState_t", "cuRAND"},
        {"surf2Dread", "surfaces"},
        {"cudaMemcpyToArray", "arrays for textures"},
    };
    return words;
}

bool is_decoration(const Token& token) {
    static const std::set<std::string_view> words = {
        "__global__",        "__device__",        "__host__",     "__constant__",
        "__managed__",       "__shared__",        "__noinline__", "__forceinline__",
        "__grid_constant__", "__launch_bounds__", "__align__"};
    return token.kind == TokenKind::identifier && words.contains(token.spelling);
}

class Translator {
 public:
    Translator(const std::string& text, CopiesOfRecords copies)
        : text_(text), tokens_(read_tokens(text)), copied_(copies == CopiesOfRecords::seen) {}

    std::string run() {
        find_kernels();
        for (at_ = 0; at_ < tokens_.all.size(); ++at_) {
            if (!tokens_.all[at_].system) step();
            // Scopes are followed in headers, too.
            follow_scopes();
        }
        return apply();
    }

 private:
    enum class Scope : unsigned char { names, members, function, kernel, lambda, block };

    struct Edit {
        std::size_t begin;
        std::size_t end;
        std::string text;
    };

    const Token& token(std::size_t i) const {
        static const Token none;
        return i < tokens_.all.size() ? tokens_.all[i] : none;
    }
    std::string source(std::size_t first, std::size_t last) const {  // last: behind the last
        if (first >= last) return "";
        return text_.substr(token(first).begin, token(last - 1).end - token(first).begin);
    }
    [[noreturn]] void refuse(const Token& where, const std::string& why) const {
        throw reference::Error::bad_input(
            tokens_.files[static_cast<std::size_t>(where.file)] + ":" + std::to_string(where.line),
            "'" + std::string(where.spelling) + "' is not supported: " + why);
    }
    void replace(std::size_t first, std::size_t last, std::string with) {
        edits_.push_back({token(first).begin, token(last - 1).end, std::move(with)});
    }
    void insert_behind(std::size_t i, std::string what) {
        edits_.push_back({token(i).end, token(i).end, std::move(what)});
    }
    void erase(std::size_t i) { replace(i, i + 1, ""); }

    /// The token behind the bracket that closes the one at `open`.
    std::size_t behind(std::size_t open) const {
        int depth = 0;
        for (std::size_t i = open; i < tokens_.all.size(); ++i) {
            const Token& t = token(i);
            if (t.kind != TokenKind::punctuation) continue;
            if (t.is("(") || t.is("[") || t.is("{")) ++depth;
            if ((t.is(")") || t.is("]") || t.is("}")) && --depth == 0) return i + 1;
        }
        return tokens_.all.size();
    }
    /// The token that opens the bracket that closes at `close`.
    std::size_t opening(std::size_t close) const {
        int depth = 0;
        for (std::size_t i = close + 1; i-- > 0;) {
            const Token& t = token(i);
            if (t.kind != TokenKind::punctuation) continue;
            if (t.is(")") || t.is("]") || t.is("}")) ++depth;
            if ((t.is("(") || t.is("[") || t.is("{")) && --depth == 0) return i;
        }
        return 0;
    }
    /// Likewise for template arguments.
    std::size_t opening_angle(std::size_t close) const {
        int depth = 0;
        for (std::size_t i = close + 1; i-- > 0;) {
            const Token& t = token(i);
            if (t.kind != TokenKind::punctuation) continue;
            if (t.is(")") || t.is("]") || t.is("}")) {
                i = opening(i);
                continue;
            }
            if (t.is(">")) ++depth;
            if (t.is("<") && --depth == 0) return i;
            if (t.is(";") || t.is("{")) break;
        }
        return close;
    }
    std::size_t behind_angle(std::size_t open) const {
        int depth = 0;
        for (std::size_t i = open; i < tokens_.all.size(); ++i) {
            const Token& t = token(i);
            if (t.kind != TokenKind::punctuation) continue;
            if (t.is("(") || t.is("[") || t.is("{")) {
                i = behind(i) - 1;
                continue;
            }
            if (t.is("<")) ++depth;
            if (t.is(">") && --depth == 0) return i + 1;
            if (t.is(">>>")) {
                depth -= 3;
                if (depth <= 0) return i + 1;
            }
            if (t.is(";")) break;
        }
        return open + 1;
    }

    /// Kernels that a launch must call by name: templates, overloads, defaults.
    void find_kernels() {
        std::map<std::string_view, int> definitions;
        for (std::size_t i = 0; i < tokens_.all.size(); ++i) {
            if (!token(i).is("__global__")) continue;
            const std::size_t open = parameters_behind(i);
            if (open == 0) continue;
            const std::string_view name = token(open - 1).spelling;
            const std::size_t close = behind(open);
            for (std::size_t p = open; p < close; ++p) {
                if (token(p).is("=")) by_name_.insert(name);
            }
            if (token(close).is("{") && ++definitions[name] > 1) by_name_.insert(name);
            // template <...> static __global__ void name(
            std::size_t before = i;
            while (before > 0 && !token(before - 1).is(";") && !token(before - 1).is("}") &&
                   !token(before - 1).is("{")) {
                --before;
            }
            if (token(before).is("template")) by_name_.insert(name);
        }
    }
    /// The parenthesis that opens the parameters of a function declared from `first` on; 0: none.
    std::size_t parameters_behind(std::size_t first) const {
        for (std::size_t i = first; i < tokens_.all.size(); ++i) {
            const Token& t = token(i);
            if (t.is("__launch_bounds__") || t.is("__align__") || t.is("__attribute__") ||
                t.is("alignas")) {
                i = behind(i + 1) - 1;
                continue;
            }
            if (t.is("(")) return token(i - 1).kind == TokenKind::identifier ? i : 0;
            if (t.is(";") || t.is("{") || t.is("}")) return 0;
        }
        return 0;
    }

    bool in_function() const {
        return std::any_of(scopes_.begin(), scopes_.end(), [](Scope scope) {
            return scope == Scope::function || scope == Scope::kernel;
        });
    }
    bool in_kernel_itself() const {
        for (std::size_t i = scopes_.size(); i-- > 0;) {
            if (scopes_[i] == Scope::kernel) return true;
            if (scopes_[i] == Scope::lambda || scopes_[i] == Scope::members) return false;
        }
        return false;
    }

    void follow_scopes() {
        const Token& t = token(at_);
        if (t.kind != TokenKind::punctuation) return;
        if (t.is("{")) {
            scopes_.push_back(scope_that_opens());
        } else if (t.is("}")) {
            if (!scopes_.empty()) scopes_.pop_back();
        }
    }
    Scope scope_that_opens() {
        if (kernel_bodies_.contains(at_)) return Scope::kernel;
        if (in_function()) {
            return opens_lambda() ? Scope::lambda : Scope::block;
        }
        // Words since the last statement say what it is.
        for (std::size_t i = at_; i-- > 0;) {
            const Token& t = token(i);
            if (t.is(";") || t.is("{") || t.is("}")) break;
            if (t.is(")")) return Scope::function;
            if (t.is("namespace")) return Scope::names;
            if (t.is("extern") && token(i + 1).kind == TokenKind::text) return Scope::names;
            if (t.is("class") || t.is("struct") || t.is("union") || t.is("enum")) {
                return Scope::members;
            }
            if (t.is("=")) return Scope::block;
        }
        return Scope::function;
    }
    /// [captures] (parameters) mutable -> type {
    bool opens_lambda() const {
        for (std::size_t i = at_; i-- > 0;) {
            const Token& t = token(i);
            if (t.is(")")) {
                i = opening(i);
                return i > 0 && (token(i - 1).is("]") || is_decoration(token(i - 1)));
            }
            if (t.is("]")) return true;
            const bool name = t.kind == TokenKind::identifier || t.is("->") || t.is("::") ||
                              t.is(">") || t.is("<") || t.is("*") || t.is("&");
            if (!name) return false;
        }
        return false;
    }

    void step() {
        const Token& t = token(at_);
        if (t.is("<<<")) {
            launch();
            return;
        }
        if (t.kind != TokenKind::identifier) return;
        if (const auto refused = refused_words().find(t.spelling);
            refused != refused_words().end()) {
            const bool member = at_ > 0 && (token(at_ - 1).is(".") || token(at_ - 1).is("->"));
            if (!member) refuse(t, refused->second);
        }
        if (copied_ && (t.is("struct") || t.is("class"))) record();
        if (t.is("__global__")) {
            const std::size_t open = parameters_behind(at_);
            if (open != 0) {
                const std::size_t close = behind(open);
                if (token(close).is("{")) kernel_bodies_.insert(close);
            }
            erase(at_);
        } else if (t.is("__host__") || t.is("__grid_constant__")) {
            erase(at_);
        } else if (t.is("__device__") || t.is("__constant__") || t.is("__managed__")) {
            variable_or_function();
            erase(at_);
        } else if (t.is("__forceinline__")) {
            replace(at_, at_ + 1, "inline");
        } else if (t.is("__noinline__") && !token(at_ - 1).is("(")) {
            replace(at_, at_ + 1, "__attribute__((noinline))");
        } else if (t.is("__align__")) {
            if (shared_until_ <= at_) {
                const std::size_t end = behind(at_ + 1);
                replace(at_, end, aligned(at_));
            }
        } else if (t.is("__launch_bounds__")) {
            const std::size_t end = behind(at_ + 1);
            replace(at_, end, "");
        } else if (t.is("__shared__")) {
            shared();
        } else if (t.is("return") && in_kernel_itself() && token(at_ + 1).is(";")) {
            insert_behind(at_, " ::scotty_cuda::leave(\"\", " + std::to_string(t.line) + ")");
        }
    }
    /// The definition of a record gets a last member that makes its copies seen
    /// (scotty_cuda/copies.h), and a name for it if it has none.
    void record() {
        if (at_ > 0 && (token(at_ - 1).is("enum") || token(at_ - 1).is("friend"))) return;
        std::size_t i = at_ + 1;
        std::string_view name;
        for (;; ++i) {
            const Token& t = token(i);
            if (t.is("alignas") || t.is("__align__") || t.is("__attribute__")) {
                i = behind(i + 1) - 1;
            } else if (t.is("[")) {
                i = behind(i) - 1;
            } else if (t.is("<")) {
                i = behind_angle(i) - 1;
            } else if (t.is("::") || t.is("final")) {
                continue;
            } else if (t.kind == TokenKind::identifier) {
                if (token(i - 1).kind == TokenKind::identifier && !name.empty())
                    return;  // struct A a
                name = t.spelling;
            } else {
                break;
            }
        }
        const std::size_t head = i;
        if (token(i).is(":")) {
            while (i < tokens_.all.size() && !token(i).is("{") && !token(i).is(";")) {
                i = token(i).is("(") ? behind(i) : token(i).is("<") ? behind_angle(i) : i + 1;
            }
        }
        if (!token(i).is("{")) return;
        const std::size_t close = behind(i) - 1;
        std::string given;
        if (name.empty()) {
            if (token(close + 1).is(";")) return;  // its members are those of what it stands in
            given = "scotty_record_" + std::to_string(next_++);
            edits_.push_back({token(head).begin, token(head).begin, given + " "});
        }
        edits_.push_back({token(close).begin, token(close).begin,
                          "public: [[no_unique_address]] ::scotty_cuda::Copied<" +
                              (given.empty() ? std::string(name) : given) + "> scotty_copied; "});
    }
    std::string aligned(std::size_t i) const {
        return "__attribute__((aligned" + source(i + 1, behind(i + 1)) + "))";
    }

    /// The first token of the expression that a launch calls.
    std::size_t kernel_expression() const {
        std::size_t first = at_;
        for (;;) {
            if (first == 0) return 0;
            std::size_t i = first - 1;
            if (token(i).is(">")) {
                i = opening_angle(i);
                if (i == 0) return first;
                first = i;
                continue;
            }
            if (token(i).is(")") || token(i).is("]")) {
                first = opening(i);
                if (first > 0 && (token(first - 1).kind == TokenKind::identifier ||
                                  token(first - 1).is(")") || token(first - 1).is("]"))) {
                    continue;
                }
            } else if (token(i).kind == TokenKind::identifier) {
                first = i;
            } else {
                return first;
            }
            while (first > 0 && (token(first - 1).is("::") || token(first - 1).is(".") ||
                                 token(first - 1).is("->"))) {
                --first;
                if (first > 0 && token(first - 1).kind == TokenKind::identifier)
                    --first;
                else
                    break;
            }
            return first;
        }
    }

    void launch() {
        if (in_kernel_itself())
            refuse(token(at_), "a kernel launches kernels (dynamic parallelism)");
        const std::size_t first = kernel_expression();
        std::size_t close = at_ + 1;
        while (close < tokens_.all.size() && !token(close).is(">>>")) {
            const Token& t = token(close);
            close = t.is("(") || t.is("{") || t.is("[") ? behind(close) : close + 1;
        }
        if (first >= at_ || !token(close + 1).is("(")) {
            refuse(token(at_), "a launch looks like kernel<<<grid, block>>>(arguments)");
        }
        const std::string kernel = source(first, at_);
        std::string name = kernel;
        std::erase(name, '\n');
        std::string quoted;
        for (const char c : name) {
            if (c == '"' || c == '\\') quoted += '\\';
            quoted += c;
        }
        std::size_t last_name = at_ - 1;
        if (token(last_name).is(">")) last_name = opening_angle(last_name) - 1;
        const bool by_name = by_name_.contains(token(last_name).spelling);
        // Edits keep the order of the text, and so its lines.
        edits_.push_back(
            {token(first).begin, token(first).begin,
             by_name ? "::scotty_cuda::generic_launcher(\"" + quoted +
                           "\", [](auto&&... scotty_a) __attribute__((no_sanitize_thread)) { "
                     : "::scotty_cuda::launcher(\"" + quoted + "\", "});
        replace(at_, at_ + 1,
                by_name ? "(static_cast<decltype(scotty_a)&&>(scotty_a)...); }, "
                          "::scotty_cuda::Config("
                        : ", ::scotty_cuda::Config(");
        replace(close, close + 1, "))");
    }

    /// `__device__` and its kin: a variable is registered behind its declaration.
    void variable_or_function() {
        if (at_ > 0 && token(at_ - 1).is("]")) return;  // of a lambda
        if (in_function()) return;
        if (!scopes_.empty() && scopes_.back() == Scope::members) return;
        std::size_t end = at_ + 1;
        std::vector<std::size_t> names;
        bool is_extern = at_ > 0 && token(at_ - 1).is("extern");
        bool names_open = true;
        bool is_set = false;
        bool is_constant = token(at_).is("__constant__");
        bool is_managed = token(at_).is("__managed__");
        for (; end < tokens_.all.size(); ++end) {
            const Token& t = token(end);
            if (t.is("extern")) is_extern = true;
            if (t.is("__constant__")) is_constant = true;
            if (t.is("__managed__")) is_managed = true;
            if (t.is("__align__") || t.is("alignas") || t.is("__attribute__") || t.is("decltype")) {
                end = behind(end + 1) - 1;
                continue;
            }
            if (t.is("<") && names_open) {
                end = behind_angle(end) - 1;
                continue;
            }
            if (t.is("(") && names_open) return;  // a function
            if (t.is("{") && names_open && names.empty() && is_class_before(end)) {
                end = behind(end) - 1;
                continue;
            }
            if (t.is("[") || t.is("=") || t.is("{") || t.is(",") || t.is(";")) {
                is_set |= t.is("=") || t.is("{");
                if (names_open) names.push_back(end - 1);
                names_open = t.is(",");
                if (t.is(";")) break;
                if (t.is("[") || t.is("{")) end = behind(end) - 1;
                continue;
            }
            if (t.is("(")) end = behind(end) - 1;
        }
        if (is_extern || registered_.contains(end)) return;
        registered_.insert(end);
        // Behind it lies a gap, in the same section, so that a step beyond lands in nobody's
        // memory.
        std::string text = " static char scotty_gap_" + std::to_string(next_++) + "[64] " +
                           "__attribute__((used))" + (is_set ? " = {1};" : ";");
        for (const std::size_t i : names) {
            const std::string name(token(i).spelling);
            const char* const space = is_constant ? "constant" : is_managed ? "managed" : "device";
            text.append(" static ::scotty_cuda::Variable scotty_variable_").append(name);
            text.append("_").append(std::to_string(next_++)).append("(&").append(name);
            text.append(", sizeof(").append(name).append("), \"").append(name);
            text.append("\", ::scotty_cuda::Space::").append(space).append(");");
        }
        insert_behind(end, text);
    }
    bool is_class_before(std::size_t open) const {
        for (std::size_t i = open; i-- > at_;) {
            if (token(i).is("struct") || token(i).is("class") || token(i).is("union")) return true;
        }
        return false;
    }

    /// A declaration of shared variables becomes one of references to the block's objects.
    void shared() {
        if (shared_until_ > at_) {
            erase(at_);
            return;
        }
        std::size_t first = at_;
        while (first > 0 && !token(first - 1).is(";") && !token(first - 1).is("{") &&
               !token(first - 1).is("}") && !token(first - 1).is(")") &&
               !token(first - 1).is(":")) {
            --first;
        }
        std::size_t end = at_;
        while (end < tokens_.all.size() && !token(end).is(";")) {
            const Token& t = token(end);
            end = t.is("(") || t.is("[") || t.is("{") ? behind(end) : end + 1;
        }
        bool is_extern = false;
        std::string specifiers;
        std::string text;
        std::size_t begin = first;
        bool is_first = true;
        while (begin < end) {
            std::size_t stop = begin;
            std::size_t name = 0;
            while (stop < end && !token(stop).is(",")) {
                const Token& t = token(stop);
                if (t.is("<")) {
                    stop = behind_angle(stop);
                } else if (t.is("__align__") || t.is("alignas") || t.is("__attribute__") ||
                           t.is("decltype")) {
                    stop = behind(stop + 1);
                } else if (t.is("[")) {
                    if (name == 0) name = stop - 1;
                    stop = behind(stop);
                } else if (t.is("=")) {
                    refuse(token(at_), "shared memory with an initialiser, which CUDA has not");
                } else {
                    stop = t.is("(") || t.is("{") ? behind(stop) : stop + 1;
                }
            }
            if (name == 0) name = stop - 1;
            std::size_t pointer = name;
            while (pointer > begin && (token(pointer - 1).is("*") || token(pointer - 1).is("&"))) {
                --pointer;
            }
            if (is_first) {
                for (std::size_t i = begin; i < pointer;) {
                    const Token& t = token(i);
                    if (t.is("extern")) is_extern = true;
                    if (t.is("extern") || t.is("static") || t.is("__shared__") ||
                        t.is("__device__")) {
                        ++i;
                    } else if (t.is("__align__") || t.is("alignas")) {
                        specifiers += aligned(i) + " ";
                        i = behind(i + 1);
                    } else {
                        specifiers += std::string(t.spelling) + " ";
                        ++i;
                    }
                }
            }
            text += shared_declaration(specifiers, source(pointer, name),
                                       std::string(token(name).spelling), source(name + 1, stop),
                                       is_extern);
            is_first = false;
            begin = stop + 1;
        }
        // The lines inside stay, so that those behind have their numbers.
        const std::string whole = source(first, end + 1);
        text += std::string(static_cast<std::size_t>(std::count(whole.begin(), whole.end(), '\n')),
                            '\n');
        std::erase_if(edits_, [&](const Edit& edit) { return edit.begin >= token(first).begin; });
        replace(first, end + 1, text);
        shared_until_ = end + 1;
    }
    std::string shared_declaration(const std::string& specifiers, const std::string& pointer,
                                   const std::string& name, const std::string& bounds,
                                   bool is_extern) {
        const std::string number = std::to_string(next_++);
        if (is_extern && in_function()) {
            return specifiers + pointer + "* const " + name + " = (" + specifiers + pointer +
                   "*)::scotty_cuda::dynamic_shared();";
        }
        if (is_extern) {
            if (!dynamic_names_.insert(name).second) return ";";
            return "static ::scotty_cuda::DynamicShared<" + specifiers + pointer + "> " + name +
                   ";";
        }
        if (!in_function())
            refuse(token(at_), "shared variables outside of functions, but for extern ones");
        const std::string type = "scotty_type_" + name + "_" + number;
        std::string kept = bounds;
        std::erase(kept, '\n');
        std::string text = "typedef " + specifiers + pointer + " " + type + kept + "; ";
        return text + "static const char scotty_site_" + number + " = 0; " + type + "& " + name +
               " = ::scotty_cuda::shared<" + type + ">(&scotty_site_" + number + ", \"" + name +
               "\");";
    }

    std::string apply() {
        std::stable_sort(edits_.begin(), edits_.end(),
                         [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
        std::string out;
        std::size_t at = 0;
        for (const Edit& edit : edits_) {
            if (edit.begin < at) continue;  // inside a larger one
            out.append(text_, at, edit.begin - at);
            out += edit.text;
            at = edit.end;
        }
        out.append(text_, at);
        return out;
    }

    const std::string& text_;
    Tokens tokens_;
    bool copied_;
    std::size_t at_ = 0;
    std::vector<Scope> scopes_;
    std::set<std::size_t> kernel_bodies_;
    std::set<std::string_view> by_name_;
    std::set<std::size_t> registered_;
    std::set<std::string> dynamic_names_;
    std::vector<Edit> edits_;
    std::size_t shared_until_ = 0;
    int next_ = 0;
};

}  // namespace

std::string translate_cuda(const std::string& text, CopiesOfRecords copies) {
    return Translator(text, copies).run();
}

}  // namespace scotty::verify
