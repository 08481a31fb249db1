#pragma once
// Attempts of a confined child to get out.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/sandbox/confined.hpp"

namespace shaker::test {

/// Outcome of a call that did what it was meant to. No call is refused with this number.
constexpr int succeeded = 200;
/// Outcome of a call that ended the child.
constexpr int died = 128 + SIGSYS;

std::string word(int outcome);

/// A call succeeds if it returns 0 or more.
using Call = std::function<long()>;

/// Result of `call` in a confined child: succeeded, died or errno.
int outcome_of(const sandbox::Confinement& allowed, const Call& call);

struct Attempt {
    const char* name;
    Call call;
    int reader;       // outcome for a child that reads files
    int writer = -1;  // and for one that writes in one folder; -1: the same
};

int opened(const std::filesystem::path& file, int flags);

/// A pretended home with a file beside the recording, and the rights for the recording alone.
class AttemptsTest : public testing::Test {
protected:
    AttemptsTest();
    /// Fails the test if a file outside of the rights has changed.
    void TearDown() override;

    /// Writers may write in out_.
    [[nodiscard]] sandbox::Confinement rights(bool writer) const;
    /// Makes every attempt in both kinds of child.
    void expect_refused(const std::vector<Attempt>& attempts) const;

    std::filesystem::path home_, own_ = home_ / "runs", secret_ = home_ / "secret";
    std::filesystem::path recording_ = own_ / "run.nxs", out_ = own_ / "run.export";
};

}  // namespace shaker::test
