/// JUnit: a suite per scene; a case per configuration, per oracle and for the BVH. One suite more
/// for the golden images, a case per image and gate.
#include <fmt/format.h>

#include <pugixml.hpp>
#include <sstream>

#include "verify/report/report.h"

namespace scotty::verify {
namespace {

struct Suite {
    pugi::xml_node node;
    int tests = 0;
    int failures = 0;
    int skipped = 0;

    void add(const std::string& name, double seconds, const std::vector<Failure>& found,
             const std::string& replay) {
        pugi::xml_node test = node.append_child("testcase");
        test.append_attribute("classname") = node.attribute("name").value();
        test.append_attribute("name") = name.c_str();
        test.append_attribute("time") = fmt::format("{:.3f}", seconds).c_str();
        ++tests;
        if (found.empty()) return;
        ++failures;
        pugi::xml_node failure = test.append_child("failure");
        failure.append_attribute("message") = to_string(found.front()).c_str();
        failure.append_attribute("type") = found.front().invariant.c_str();
        std::string text;
        for (const Failure& one : found) text += to_string(one) + "\n";
        failure.append_child(pugi::node_pcdata).set_value((text + replay).c_str());
    }

    void add(const ImageCase& image, const GateResult& gate) {
        std::vector<Failure> found;
        if (gate.failed()) {
            for (const Failure& one : failures_of(image)) {
                if (one.invariant == fmt::format("image-{}", name(gate.gate))) found.push_back(one);
            }
        }
        add(fmt::format("{}: {}", image.name, name(gate.gate)), 0.0, found,
            image.replay + "\n" + image.approve);
        pugi::xml_node test = node.last_child();
        if (!gate.ran) {
            ++skipped;
            test.append_child("skipped").append_attribute("message") = gate.text.c_str();
            return;
        }
        // Attributes would break the schema that most readers of JUnit hold files against.
        const ImageMetrics& shown = image.verdict.metrics;
        test.append_child("system-out")
            .append_child(pugi::node_pcdata)
            .set_value(fmt::format("{}\nstatistic {:.6g}, p {:.6g}, fails below {:.6g}\n"
                                   "not judged by: FLIP {:.6g}, relMSE {:.6g}, PSNR {:.6g} dB\n",
                                   gate.text, gate.statistic, gate.p_value, gate.threshold,
                                   shown.flip, shown.rel_mse, shown.psnr)
                           .c_str());
    }

    void finish(double seconds) {
        node.append_attribute("tests") = tests;
        node.append_attribute("failures") = failures;
        if (skipped != 0) node.append_attribute("skipped") = skipped;
        node.append_attribute("time") = fmt::format("{:.3f}", seconds).c_str();
    }
};

}  // namespace

std::string to_junit(const Report& report) {
    pugi::xml_document document;
    pugi::xml_node declaration = document.prepend_child(pugi::node_declaration);
    declaration.append_attribute("version") = "1.0";
    declaration.append_attribute("encoding") = "UTF-8";
    pugi::xml_node root = document.append_child("testsuites");
    root.append_attribute("name") = "scotty verify";
    for (const SceneReport& scene : report.scenes) {
        Suite suite{root.append_child("testsuite")};
        suite.node.append_attribute("name") = scene.scene.c_str();
        const std::string baseline =
            scene.configurations.empty() ? "" : scene.configurations.front().replay;
        suite.add("BVH", 0.0, scene.bvh_failures, baseline);
        for (const ConfigurationReport& c : scene.configurations) {
            suite.add(c.label, c.seconds, c.failures, c.replay);
        }
        if (scene.oracles_ran) {
            suite.add("hits against brute force and Embree", scene.oracle_seconds,
                      scene.hits.failures, baseline);
            suite.add("image against Embree", 0.0, scene.image.failures, baseline);
        }
        suite.finish(scene.seconds);
    }
    if (!report.images.empty() || !report.golden_failures.empty()) {
        Suite suite{root.append_child("testsuite")};
        suite.node.append_attribute("name") = "golden images";
        suite.add("golden files", 0.0, report.golden_failures, "scotty golden check");
        for (const ImageCase& image : report.images) {
            suite.add(image.name + ": exact", 0.0, image.exact, image.replay);
            for (const GateResult& gate : image.verdict.gates) suite.add(image, gate);
        }
        suite.finish(0.0);
    }
    if (!report.stopped.empty()) {  // what was not judged must not look as if it had passed
        Suite suite{root.append_child("testsuite")};
        suite.node.append_attribute("name") = "all was judged";
        Failure failure;
        failure.invariant = "stopped";
        failure.sentence = report.stopped;
        suite.add("all was judged", 0.0, {failure}, report.command);
        suite.finish(0.0);
    }
    std::ostringstream text;
    document.save(text, "  ");
    return text.str();
}

}  // namespace scotty::verify
