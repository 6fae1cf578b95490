/// Hashes of the contract's tables, as text.
#include <fmt/format.h>

#include <string>

#include "reference/contract/buffers.h"
#include "reference/contract/parameter_table.h"
#include "reference/contract/stages.h"
#include "verify/golden/hash_book.h"

namespace scotty::verify {

namespace {

std::string_view name_of(const reference::BufferInfo* info) {
    return info == nullptr ? std::string_view("none") : info->name;
}

std::string parameters_as_text() {
    std::string text;
    for (const reference::ParameterInfo& info : reference::kParameters) {
        text += fmt::format("{} {} {} {} {} {} {} {} {}\n", info.name, info.option, info.title,
                            info.help, static_cast<int>(info.group), valid_values(info),
                            info.zero_is_all, info.added_later, text_of(info, {}));
    }
    return text;
}

std::string buffers_as_text() {
    std::string text;
    for (const reference::BufferInfo* info : reference::kBuffers) {
        text += fmt::format(
            "{} {} {} {} {} {} {} {} {} {} {} {} {} {}\n", info->name, static_cast<int>(info->row),
            static_cast<int>(info->content), static_cast<int>(info->order), name_of(info->lengths),
            name_of(info->offsets), name_of(info->written_as), info->depends_on_timing,
            info->tolerance.relative, info->tolerance.share, info->tolerance.only, info->meaning,
            static_cast<int>(info->type), info->element_bytes);
        for (const reference::Field& field : info->fields) {
            text += fmt::format("  {} {} {} {}\n", field.name, field.is_float,
                                field.may_be_infinite, field.blank);
        }
    }
    return text;
}

std::string stages_as_text() {
    std::string text;
    const auto list = [&](const char* what, const auto& buffers) {
        text += fmt::format("  {}:", what);
        for (const auto& one : buffers) {
            text += fmt::format(" {} {}", name_of(one.buffer), static_cast<int>(one.when));
        }
        text += '\n';
    };
    for (const reference::StageInfo& stage : reference::kStages) {
        text += fmt::format("{} {} {} {} {}\n", static_cast<int>(stage.kind), stage.name,
                            stage.label, static_cast<int>(stage.thread), stage.of_traversal);
        list("inputs", stage.inputs);
        list("outputs", stage.outputs);
        list("lowers", stage.lowers);
        list("needs", stage.needs);
        for (const auto& need : stage.needs) text += std::to_string(static_cast<int>(need.source));
        for (const char* invariant : stage.invariants) text += fmt::format("  {}\n", invariant);
    }
    return text;
}

}  // namespace

Hashes table_hashes() {
    return {{"table of parameters", hash_of_text(parameters_as_text())},
            {"table of buffers", hash_of_text(buffers_as_text())},
            {"table of stages", hash_of_text(stages_as_text())}};
}

}  // namespace scotty::verify
