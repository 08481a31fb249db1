#include "daemon/run/stop_signals.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>

#include "drivers/errors.hpp"

namespace shaker::run {

namespace {

constexpr std::array stop_signals{SIGINT, SIGTERM, SIGHUP};
std::atomic<Runner*> asked{nullptr};
std::atomic<int> first{0};

extern "C" void ask_to_stop(int signal) {
    int none = 0;
    first.compare_exchange_strong(none, signal);
    if (Runner* runner = asked) runner->request_stop();
}

void handle(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    for (const int signal : stop_signals) sigaction(signal, &action, nullptr);
}

}  // namespace

StopSignals::StopSignals() {
    first = 0;
    handle(ask_to_stop);
}

StopSignals::StopSignals(Runner& runner) : StopSignals{} { asked = &runner; }

StopSignals::~StopSignals() {
    handle(SIG_DFL);
    asked = nullptr;
}

void StopSignals::rethrow() {
    if (const int signal = first)
        throw Interrupted{signal, std::string{"interrupted by SIG"} + sigabbrev_np(signal)};
}

}  // namespace shaker::run
