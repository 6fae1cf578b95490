#include "verify/commands/report_outputs.h"

#include "reference/base/write_file.h"
#include "verify/base/output_path.h"
#include "verify/commands/command.h"

namespace scotty::verify {

void add_report_outputs(CLI::App& command, ReportOutputs& outputs) {
    add_json_option(command, outputs.json);
    command.add_option("--junit", outputs.junit, "write the report as JUnit XML")
        ->type_name("FILE")
        ->check(output_file());
    command.add_option("--html", outputs.html, "write the report as one HTML page")
        ->type_name("FILE")
        ->check(output_file());
}

void write_report(const ReportOutputs& outputs, const Report& report,
                  const nlohmann::json& as_json) {
    if (!outputs.junit.empty()) reference::write_file(outputs.junit, to_junit(report));
    if (!outputs.html.empty()) reference::write_file(outputs.html, to_html(report));
    print_result(outputs.json, as_json.dump(2), table(report));
}

}  // namespace scotty::verify
