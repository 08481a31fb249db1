// The journal of a campaign is read back unchanged. After a crash it is read up to the line that was being
// written.
#include "daemon/campaign/journal.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "drivers/errors.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::campaign {
namespace {

using test::expect_in;
using test::refusal;

PassEnded pass() {
    PassEnded p{.point = 7,
                .pass = 2,
                .recording = "r3",
                .measurement = 5,
                .from_s = 0.1,
                .to_s = 2.1000000000000001};
    p.x_from_m = -0.03;
    p.true_v_D = 0.0145824;
    p.how = PassEnded::How::early;
    p.reason = "the walker came within 5 mm of the edge";
    return p;
}

std::vector<JournalEntry> every_kind() {
    using Change = CampaignChange::What;
    return {{"2026-11-25T17:00:00+01:00", CampaignChange{Change::begun, "", "0123abcd"}},
            {"t", PointBegun{7, true}},
            {"t", pass()},
            {"t", PassLost{7, 2, "r3.nxs does not exist"}},
            {"t", PointEnded{7, Outcome::left_out, "a \"quoted\" reason,\nof two lines, \xCE\xB3 = 3 g"}},
            {"t", Returned{7, -0.03, 0.01, 0.0102, 1.5}},
            {"t", CampaignChange{Change::paused, "limit", ""}}};
}

std::string text_of(const std::vector<JournalEntry>& entries) {
    std::string text;
    for (const JournalEntry& e : entries) text += line_of(e) + '\n';
    return text;
}

TEST(CampaignJournalTest, EveryKindIsReadBackUnchanged) {
    const std::string text = text_of(every_kind());
    EXPECT_EQ(std::ranges::count(text, '\n'), 7);
    const ReadJournal read = parse_journal(text, "journal");
    EXPECT_EQ(read.remark, "");
    EXPECT_EQ(text_of(read.entries), text);
    const auto p = std::get<PassEnded>(read.entries.at(2).what);
    EXPECT_EQ(p.to_s, pass().to_s);
    EXPECT_EQ(p.true_v_D, pass().true_v_D);
    EXPECT_TRUE(std::isnan(p.x_to_m)) << "unknown stays unknown";
    EXPECT_EQ(p.how, PassEnded::How::early);
    EXPECT_EQ(p.reason, pass().reason);
    EXPECT_EQ(std::get<PointEnded>(read.entries.at(4).what).reason,
              std::get<PointEnded>(every_kind()[4].what).reason);
}

TEST(CampaignJournalTest, TornLastLineIsDroppedAndNamed) {
    const std::vector<JournalEntry> all = every_kind();
    const std::string text = text_of(all), last = line_of(all.back());
    for (std::size_t lost = 1; lost <= last.size(); ++lost) {
        const ReadJournal read = parse_journal(text.substr(0, text.size() - lost), "j.jsonl");
        ASSERT_EQ(read.entries.size(), all.size() - 1) << lost;
        expect_in(read.remark, {"j.jsonl line 7", "dropped"});
    }
    EXPECT_EQ(parse_journal(text.substr(0, text.size() - last.size() - 1), "j").remark, "")
        << "a whole line is lost";
    expect_in(parse_journal(text + std::string(40, '\0') + "\n", "j").remark, {"line 8"});
}

TEST(CampaignJournalTest, BadLineIsRefusedWithItsNumber) {
    const std::string good = line_of({"t", PointBegun{1, false}}) + '\n';
    for (const char* bad : {"", "{", "7", "{}", R"({"time":"t","what":"lunch"})",
                            R"({"time":"t","what":"point begun","point":1.5,"keeps_passes":false})",
                            R"({"time":"t","what":"point begun","point":5000000000,"keeps_passes":false})",
                            R"({"time":"t","what":"point begun","keeps_passes":false})",
                            R"({"time":"t","what":"point ended","point":1,"outcome":"good","reason":""})"})
        expect_in(refusal([&] { parse_journal(good + bad + "\n" + good, "j.jsonl"); }), {"j.jsonl line 2"});
}

class JournalFileTest : public testing::Test {
protected:
    void add(const JournalEntry& entry) const { Journal{file_}.add(entry); }
    test::SessionFolder folder_;
    std::filesystem::path file_ = folder_ / "journal.jsonl";
};

TEST_F(JournalFileTest, ContinuesBehindTornLine) {
    folder_.write("journal.jsonl", text_of(every_kind()) + R"({"time":"t","wh)");
    EXPECT_NE(read_journal(file_).remark, "");
    add({"t", PointBegun{9, false}});
    const ReadJournal read = read_journal(file_);
    EXPECT_EQ(read.remark, "");
    ASSERT_EQ(read.entries.size(), 8U);
    EXPECT_EQ(std::get<PointBegun>(read.entries.back().what).point, 9);
}

TEST_F(JournalFileTest, FailedWriteLeavesFileAsItWas) {
    Journal journal{file_};
    journal.add({"t", PointBegun{1, false}});
    const auto size = std::filesystem::file_size(file_);
    struct rlimit before {};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const struct rlimit full { size + 10, before.rlim_max };  // room for a part of the line
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
    EXPECT_THROW(journal.add({"t", PointBegun{2, false}}), DeviceError);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    std::signal(SIGXFSZ, handler);
    EXPECT_EQ(std::filesystem::file_size(file_), size);
    journal.add({"t", PointBegun{2, false}});
    EXPECT_EQ(read_journal(file_).entries.size(), 2U);
}

}  // namespace
}  // namespace shaker::campaign
