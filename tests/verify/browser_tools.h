/// Pages in a real browser: what they say of themselves when they are opened with #selftest.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/base/ask.h"

namespace scotty::verify::test {

inline bool browser_is_here() { return std::system("command -v chromium >/dev/null 2>&1") == 0; }

/// What each page, by its name, found out about itself. One browser for all, because starting it
/// takes longer than all the rest: each page is in a frame of its own.
inline std::map<std::string, std::string> self_tests(
    const std::map<std::string, std::string>& pages) {
    const TemporaryFolder folder;
    std::string frames = "<!doctype html><body>";
    for (const auto& [name, page] : pages) {
        spill(folder / (name + ".html").c_str(), page);
        frames += "<iframe width='1280' height='900' id='" + name + "' src='" + name +
                  ".html#selftest'></iframe>";
    }
    spill(folder / "all.html", frames + R"(<script>onload = () => {
        for (const frame of document.querySelectorAll('iframe')) {
            const page = frame.contentDocument;
            const found = page.getElementById('selftest');
            document.body.append(`{${frame.id}: ${found ? found.textContent : 'no answer'}}`);
        }
    };</script>)");
    const std::string command =
        "chromium --headless --no-sandbox --disable-gpu --no-first-run "
        "--allow-file-access-from-files --user-data-dir=" +
        verify::shell_word(folder / "profile") + " --dump-dom " +
        verify::shell_word("file://" / (folder / "all.html")) + " >" +
        verify::shell_word(folder / "dom") + " 2>" + verify::shell_word(folder / "log");
    const int status = std::system(command.c_str());
    const std::string dom = slurp(folder / "dom");
    INFO(command << "\n" << slurp(folder / "log"));
    REQUIRE(WIFEXITED(status));
    REQUIRE(WEXITSTATUS(status) == 0);
    std::map<std::string, std::string> found;
    for (const auto& [name, page] : pages) {
        const std::size_t start = dom.find("{" + name + ": ");
        REQUIRE(start != std::string::npos);
        found[name] = dom.substr(start, dom.find('}', start) - start);
    }
    return found;
}

}  // namespace scotty::verify::test
