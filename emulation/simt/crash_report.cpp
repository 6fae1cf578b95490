#include "emulation/simt/crash_report.h"

#include <unistd.h>

#include <csignal>
#include <cstring>

#include "emulation/simt/context.h"

namespace scotty::emulation::simt {

namespace {

/// Text and numbers to standard error with nothing but what a signal handler may call.
class Line {
 public:
    Line& operator<<(const char* text) {
        while (*text != '\0' && size_ < sizeof text_) text_[size_++] = *text++;
        return *this;
    }
    Line& operator<<(std::uint32_t number) {
        char digits[11];
        std::size_t at = sizeof digits - 1;
        digits[at] = '\0';
        do {
            digits[--at] = static_cast<char>('0' + number % 10);
            number /= 10;
        } while (number != 0);
        return *this << digits + at;
    }
    void print() const {
        const auto written = ::write(STDERR_FILENO, text_, size_);
        static_cast<void>(written);
    }

 private:
    char text_[512];
    std::size_t size_ = 0;
};

void report(int signal) {
    if (context.kernel != nullptr) {
        Line line;
        line << "kernel " << context.kernel << ", block " << context.block << " ("
             << context.block_size << " threads): thread " << context.thread
             << " reached memory that is not there\n";
        line.print();
    }
    std::signal(signal, SIG_DFL);
    ::raise(signal);
}

}  // namespace

void report_crashes() {
    for (const int signal : {SIGSEGV, SIGBUS}) {
        struct sigaction installed {};
        if (::sigaction(signal, nullptr, &installed) != 0) continue;
        if (installed.sa_handler == SIG_DFL) std::signal(signal, report);
    }
}

}  // namespace scotty::emulation::simt
