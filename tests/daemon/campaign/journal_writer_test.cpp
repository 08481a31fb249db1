// Entries reach the journal in their order; one that the disk refuses is kept and written later.
#include "daemon/campaign/lead/journal_writer.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "drivers/errors.hpp"
#include "tests/support/program.hpp"

namespace shaker::campaign {
namespace {

constexpr const char* plan = "[[series]]\ngamma = \"1g\"\n";

/// No file grows beyond this during its life.
class SmallFiles {
public:
    explicit SmallFiles(rlim_t bytes) : handler_{std::signal(SIGXFSZ, SIG_IGN)} {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        rlimit small = before_;
        small.rlim_cur = bytes;
        ::setrlimit(RLIMIT_FSIZE, &small);
    }
    ~SmallFiles() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }
    SmallFiles(const SmallFiles&) = delete;
    SmallFiles& operator=(const SmallFiles&) = delete;

private:
    rlimit before_{};
    void (*handler_)(int);
};

class JournalWriterTest : public testing::TestWithParam<bool> {
protected:
    [[nodiscard]] std::vector<int> points() const {
        std::vector<int> found;
        for (const JournalEntry& e : read_journal(folder_ / journal_name).entries)
            if (const auto* p = std::get_if<PointBegun>(&e.what)) found.push_back(p->point);
        return found;
    }
    std::filesystem::path folder_ = test::fresh_folder() / "points";
};

TEST_P(JournalWriterTest, WritesInOrder) {
    CampaignFolder folder = CampaignFolder::begin(folder_, plan);
    JournalWriter writer{folder, GetParam()};
    std::vector<int> added;
    for (int i = 1; i <= 20; ++i) writer.add(PointBegun{.point = i}), added.push_back(i);
    writer.finish();
    EXPECT_EQ(writer.failure(), "");
    EXPECT_EQ(points(), added);
}

TEST_P(JournalWriterTest, RefusedEntryIsWrittenLater) {
    CampaignFolder folder = CampaignFolder::begin(folder_, plan);
    JournalWriter writer{folder, GetParam()};
    writer.add(PointBegun{.point = 1});
    writer.finish();
    {
        const SmallFiles full{std::filesystem::file_size(folder_ / journal_name) + 10};
        writer.add(PointBegun{.point = 2});
        writer.add(PointBegun{.point = 3});
        EXPECT_THROW(writer.finish(), DeviceError);
        EXPECT_NE(writer.failure().find(journal_name), std::string::npos) << writer.failure();
        EXPECT_EQ(points(), std::vector{1});
    }
    for (int i = 0; i < 100 && !writer.failure().empty(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds{50});
    writer.finish();
    EXPECT_EQ(points(), (std::vector{1, 2, 3}));
}

INSTANTIATE_TEST_SUITE_P(Beside, JournalWriterTest, testing::Bool(),
                         [](const auto& one) { return one.param ? "thread" : "at_once"; });

}  // namespace
}  // namespace shaker::campaign
