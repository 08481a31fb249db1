// A power cut may damage any block of a file that is being written: readable data are kept, and damage costs
// only its own rows.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/h5/seals.hpp"
#include "drivers/recorded/opened_recording.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker::recorded {

using namespace test;
namespace {

// Enough rows for an index of several blocks.
Session long_session() {
    Session s = small_session();
    const PlayTime last = s.played.back();
    for (std::int64_t i = 1; i <= 30000; ++i)
        s.played.push_back({{last.tick.n + 240 * i}, last.heard + std::chrono::milliseconds{5} * i, 0});
    return s;
}

std::vector<std::size_t> places_of(const std::string& bytes, const std::string& signature) {
    std::vector<std::size_t> places;
    for (std::size_t at = bytes.find(signature); at != std::string::npos; at = bytes.find(signature, at + 1))
        places.push_back(at);
    return places;
}

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

class SessionMendTest : public ::testing::Test {
protected:
    SessionMendTest() {
        write(long_session(), folder_ / "whole.nxs");
        whole_ = bytes_of(folder_ / "whole.nxs");
    }
    // With a seal from time to time, as in a run.
    static void write(const Session& s, const std::filesystem::path& file) {
        RecordingWriter writer{file, s.header};
        for (const DriveChange& c : s.changes) writer.add(c);
        for (const AccelBlock& b : s.blocks) writer.add(b);
        for (std::size_t k = 0; k < s.frames.size(); ++k)
            for (const FramePtr& f : s.frames[k]) writer.add(k, *f, 0);
        writer.rows("tracks/top/walker", s.walker);
        for (std::size_t i = 0; i < s.played.size(); ++i) {
            writer.add(s.played[i]);
            if (i % 1000 == 999) writer.flush();
        }
        writer.scalar("results/v_D", s.v_D);
        writer.close();
    }
    // Columns and their rows after mending a file with these bytes. Each column must be the start of the
    // written one.
    std::map<std::string, std::size_t> mended(const std::string& bytes) {
        const std::filesystem::path file = folder_.write("torn.nxs", bytes);
        RecordingWriter::mend(file).close();
        RecordingWriter again = RecordingWriter::mend(file);  // as in a recovery, which adds results
        again.rows("tracks/top/walker", {{"t", "s", {9}}, {"x", "m", {9}}, {"x_errors", "m", {9}}});
        again.close();
        const RecordingReader is{file}, was{folder_ / "whole.nxs"};
        EXPECT_EQ(is.damage(), std::vector<std::string>{});
        std::map<std::string, std::size_t> rows;
        for (const h5::SealedColumn& c : h5::read_seals(is.opened().entry.get())) {
            if (h5::description_of(is.opened().entry.get(), c.path).shape.empty()) continue;  // written once
            const h5::Bytes a = h5::read_bytes(is.opened().entry.get(), c.path),
                            b = h5::read_bytes(was.opened().entry.get(), c.path);
            const std::size_t added = c.path.starts_with("tracks/") ? a.row : 0;
            rows[c.path] = (a.values.size() - added) / a.row;
            EXPECT_LE(a.values.size() - added, b.values.size()) << c.path;
            EXPECT_TRUE(std::equal(a.values.begin(), a.values.end() - static_cast<std::ptrdiff_t>(added),
                                   b.values.begin()))
                << c.path;
        }
        return rows;
    }
    SessionFolder folder_;
    std::string whole_;
};

TEST_F(SessionMendTest, IntactFileKeepsEveryRow) {
    const auto rows = mended(whole_);
    EXPECT_EQ(rows.at("raw/drive/play_tick"), long_session().played.size());
    EXPECT_EQ(rows.at("raw/accelerometer/block_first"), long_session().blocks.size());
}

TEST_F(SessionMendTest, TornIndexBlockCostsOnlyItsGroup) {
    const auto all = mended(whole_);
    for (const char* kind : {"EAHD", "EAIB", "EADB"}) {
        const std::vector<std::size_t> places = places_of(whole_, kind);
        EXPECT_GT(places.size(), 0U) << kind;
        int of_all = 0;  // the index of the seals: no later data can be verified
        for (const std::size_t at : places) {
            SCOPED_TRACE(testing::Message() << kind << " at " << at);
            std::string torn = whole_;
            std::fill_n(torn.begin() + static_cast<std::ptrdiff_t>(at), 16, '\0');
            std::set<std::string> families;
            for (const auto& [path, rows] : mended(torn)) {
                const std::string group = path.substr(0, path.rfind('/'));
                if (rows == all.at(path)) continue;
                families.insert(group == "tracks/top/walker" ? "raw/top" : group);
                const std::size_t known_to_the_index_itself = std::string{"EADB"} == kind ? 2048 : 0;
                EXPECT_GE(rows, known_to_the_index_itself) << path;
            }
            of_all += families.size() > 1 ? 1 : 0;
        }
        EXPECT_LE(of_all, 4) << kind << ": the seals have four columns of one block";
    }
}

}  // namespace
}  // namespace shaker::recorded
