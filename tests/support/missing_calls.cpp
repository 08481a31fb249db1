#include "tests/support/missing_calls.hpp"

#include <linux/landlock.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <stdexcept>
#include <thread>

namespace shaker::test {

namespace {

/// From now on, for this thread and its children.
void refuse(int call, int error) {
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    const std::unique_ptr<void, decltype(&seccomp_release)> rules{seccomp_init(SCMP_ACT_ALLOW),
                                                                  seccomp_release};
    if (seccomp_rule_add(rules.get(), SCMP_ACT_ERRNO(static_cast<unsigned>(error)), call, 0) < 0 ||
        seccomp_load(rules.get()) < 0)
        throw std::runtime_error{"a system call cannot be hidden"};
}

}  // namespace

bool has_landlock() {
    return ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) >= 1;
}

void without_call(int call, int error, const std::function<void()>& work) {
    std::thread{[&] {
        refuse(call, error);
        work();
    }}.join();
}

void without_landlock(const std::function<void()>& work) {
    without_call(SCMP_SYS(landlock_create_ruleset), EOPNOTSUPP, work);
}

}  // namespace shaker::test
