#include "tests/support/no_landlock.hpp"

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
void refuse_landlock() {
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    const std::unique_ptr<void, decltype(&seccomp_release)> rules{seccomp_init(SCMP_ACT_ALLOW),
                                                                  seccomp_release};
    if (seccomp_rule_add(rules.get(), SCMP_ACT_ERRNO(EOPNOTSUPP), SCMP_SYS(landlock_create_ruleset), 0) < 0 ||
        seccomp_load(rules.get()) < 0)
        throw std::runtime_error{"Landlock cannot be hidden"};
}

}  // namespace

bool has_landlock() {
    return ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) >= 1;
}

void without_landlock(const std::function<void()>& work) {
    std::thread{[&] {
        refuse_landlock();
        work();
    }}.join();
}

}  // namespace shaker::test
