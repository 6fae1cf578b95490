// A check as JUnit, for build servers.
#include <fmt/format.h>

#include <pugixml.hpp>
#include <sstream>

#include "verify/kernel_check/kernel_check.h"

namespace scotty::verify {

std::string to_junit(const KernelReport& report) {
    pugi::xml_document document;
    pugi::xml_node suite = document.append_child("testsuites").append_child("testsuite");
    suite.append_attribute("name") = "scotty check";
    suite.append_attribute("tests") = 1;
    suite.append_attribute("failures") = report.failed ? 1 : 0;
    pugi::xml_node test = suite.append_child("testcase");
    test.append_attribute("classname") = "scotty check";
    test.append_attribute("name") = report.name.c_str();
    test.append_attribute("time") = fmt::format("{:.3f}", report.seconds).c_str();
    if (report.failed) {
        pugi::xml_node failure = test.append_child("failure");
        const std::string message = report.findings.empty()
                                        ? fmt::format("exit code {}", report.exit_code)
                                        : report.findings[0]["kind"].get<std::string>() + ": " +
                                              report.findings[0]["what"].get<std::string>();
        failure.append_attribute("message") = message.c_str();
        failure.append_child(pugi::node_pcdata).set_value(report.text.c_str());
    }
    std::ostringstream out;
    document.save(out, "  ");
    return out.str();
}

}  // namespace scotty::verify
