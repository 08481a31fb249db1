// Rows of a table are read back unchanged. Values that no member can have are refused with their place.
#include "daemon/recording/tables/columns.hpp"

#include <gtest/gtest.h>

#include <complex>

#include "daemon/recording/tables/differences.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "tests/support/recording/recording_folder.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker::recording {
namespace {

enum class Colour { red, green };

struct Part {
    double x = 0;
};

struct Row {
    std::int64_t n = 0;
    Part part;
    MasterTime time;
    Colour colour{};
    bool on = false;
    std::string word;
};

constexpr std::array numbers{
    number<&Row::n>("n", "1", "count"),
    number<&Row::part, &Part::x>("x", "m", "position"),
    number<&Row::time>("t", "s", "time"),
    number<&Row::colour>("colour", "1", "0 red, 1 green"),
    number<&Row::on>("on", "1", "0 or 1"),
    NumberColumn<Row>{"twice", "m", "2 x", [](const Row& r) { return 2 * r.part.x; }}};
constexpr std::array texts{text<&Row::word>("word", 8, "a word")};
constexpr Table<Row> table{"rows", "rows of a test", numbers, texts};

class ColumnsTest : public testing::Test {
protected:
    void write(const std::vector<std::vector<double>>& columns, const std::vector<std::string>& words) const {
        recorded::RecordingHeader header = test::small_header();
        header.groups = {layout_of(table)};
        std::filesystem::remove(file_);
        recorded::RecordingWriter writer{file_, header};
        RecordedTable rows = table_of(table, std::vector<Row>{});
        for (std::size_t i = 0; i < columns.size(); ++i) rows.columns[i].values = columns[i];
        recording::write(writer, {rows});
        writer.texts("rows/word", words);
        writer.close();
    }
    [[nodiscard]] std::string refusal() const {
        return test::refusal([&] { read_rows(recorded::RecordingReader{file_}, table); });
    }
    test::SessionFolder folder_;
    std::filesystem::path file_ = folder_ / "rows.nxs";
};

TEST_F(ColumnsTest, RowsAreReadBackUnchanged) {
    const std::vector<Row> rows{{-7, {0.1}, master_time(2.5), Colour::green, true, "a"},
                                {1LL << 52, {-0.0}, master_time(-1e-9), Colour::red, false, ""}};
    {
        recorded::RecordingHeader header = test::small_header();
        header.groups = {layout_of(table)};
        recorded::RecordingWriter writer{file_, header};
        write_rows(writer, table, rows);
        writer.close();
    }
    const recorded::RecordingReader reader{file_};
    const std::vector<Row> read = read_rows(reader, table);
    ASSERT_EQ(read.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        EXPECT_EQ(read[i].n, rows[i].n);
        EXPECT_EQ(read[i].part.x, rows[i].part.x);
        EXPECT_EQ(read[i].time, rows[i].time);
        EXPECT_EQ(read[i].colour, rows[i].colour);
        EXPECT_EQ(read[i].on, rows[i].on);
        EXPECT_EQ(read[i].word, rows[i].word);
    }
    EXPECT_EQ(reader.numbers("rows/twice"), (std::vector<double>{0.2, -0.0}));
    EXPECT_TRUE(differences(reader, {}, {table_of(table, rows)}).empty());
}

TEST_F(ColumnsTest, ColumnsOfDifferentLengthAreRefused) {
    write({{1, 2}, {1, 2}, {1, 2}, {0, 1}, {0, 1}, {2, 4}}, {"a"});
    test::expect_in(refusal(), {"rows/n has 2 rows", "rows/word has 1"});
}

TEST_F(ColumnsTest, ImpossibleValuesAreRefused) {
    for (const double value : {0.5, 1e300, static_cast<double>(NAN)}) {
        write({{1, value}, {1, 2}, {1, 2}, {0, 1}, {0, 1}, {2, 4}}, {"a", "b"});
        test::expect_in(refusal(), {"rows/n row 1", "is not a value"});
    }
    write({{1, 2}, {1, 2}, {1, 2}, {0, 3e9}, {0, 1}, {2, 4}}, {"a", "b"});
    test::expect_in(refusal(), {"rows/colour row 1"});
}

TEST_F(ColumnsTest, DifferencesNameColumnRowAndMeasurement) {
    write({{1, 2}, {1, 2}, {1, 2}, {0, 1}, {0, 1}, {2, 4}}, {"a", "b"});
    const recorded::RecordingReader reader{file_};
    RecordedTable now = table_of(table, read_rows(reader, table));
    now.columns[1].values[1] = 2.5;
    const std::vector<std::string> found = differences(reader, {}, {now});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0], "rows/x row 1: recorded 2, now 2.5");
    now.columns[1].values.pop_back();
    test::expect_in(differences(reader, {}, {now}).at(0), {"rows/x", "2 rows recorded, now 1"});
}

FinishedMeasurement measurement(int number) {
    FinishedMeasurement m{number, {}, {1.0 * number, 1.0 * number + 2}, "2026-11-22T03:14:15+01:00"};
    m.asked = {.frequency = 25, .gamma = 7, .rho = 0.4, .phi = -1};
    if (number == 2) m.asked.overtones[3] = {0.1, -0.2};
    return m;
}

class MeasuredTablesTest : public testing::Test {
protected:
    void write(const std::vector<FinishedMeasurement>& all) const {
        recorded::RecordingHeader header = test::small_header();
        header.groups = measured_places();
        recorded::RecordingWriter writer{file_, header};
        for (const FinishedMeasurement& m : all) recording::write(writer, m);
        for (const FinishedMeasurement& m : all)
            recording::write(writer, m.number == 3 ? MeasuredResult{m, std::nullopt, "too short"}
                                                   : MeasuredResult{m, result(m.number), {}});
        writer.close();
    }
    static reduction::Reduction result(int number) {
        reduction::Reduction r;
        r.v_D = {0.01 * number, 1e-5};
        r.periods.resize(static_cast<std::size_t>(number));
        r.notes = {"a note"};
        return r;
    }
    test::SessionFolder folder_;
    std::filesystem::path file_ = folder_ / "measured.nxs";
};

TEST_F(MeasuredTablesTest, SetPointPartAndTimeAreReadBack) {
    write({measurement(1), measurement(2)});
    const std::vector<FinishedMeasurement> read = read_finished(recorded::RecordingReader{file_});
    ASSERT_EQ(read.size(), 2U);
    for (const int n : {1, 2}) {
        const FinishedMeasurement &got = read[static_cast<std::size_t>(n - 1)], wrote = measurement(n);
        EXPECT_EQ(got.number, n);
        EXPECT_EQ(got.part, wrote.part);
        EXPECT_EQ(got.time, wrote.time);
        EXPECT_EQ(got.asked.gamma, 7);
        EXPECT_EQ(got.asked.rho, 0.4);
        EXPECT_EQ(got.asked.phi, -1);
        EXPECT_EQ(got.asked.frequency, 25);
        EXPECT_EQ(got.asked.overtones, wrote.asked.overtones);
    }
}

TEST_F(MeasuredTablesTest, RowsOfEachResultCarryItsNumber) {
    write({measurement(1), measurement(2), measurement(3)});
    const recorded::RecordingReader reader{file_};
    EXPECT_EQ(reader.numbers("measured/results/measurement"), (std::vector<double>{1, 2}));
    EXPECT_EQ(reader.numbers("measured/results/v_D"), (std::vector<double>{0.01, 0.02}));
    EXPECT_EQ(reader.numbers("measured/periods/measurement"), (std::vector<double>{1, 2, 2}));
    EXPECT_EQ(reader.texts("measured/notes/text"),
              (std::vector<std::string>{"a note", "a note", "not reduced: too short"}));
}

TEST_F(MeasuredTablesTest, ADifferenceNamesItsMeasurement) {
    write({measurement(1), measurement(2)});
    std::vector<RecordedTable> now;
    append(now, {measurement(1), result(1), {}});
    reduction::Reduction other = result(2);
    other.v_D.value = 0.03;
    append(now, {measurement(2), other, {}});
    const std::vector<std::string> found = differences(recorded::RecordingReader{file_}, {}, now);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0], "measured/results/v_D row 1 (measurement 2): recorded 0.02, now 0.03");
}

TEST_F(MeasuredTablesTest, OvertoneWithoutMeasurementIsRefused) {
    FinishedMeasurement m = measurement(2);
    write({m});
    {
        const h5::Handle file{H5Fopen(file_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
        const h5::Handle group = h5::open_group(file.get(), "entry/measured/overtones");
        h5::check(H5Ldelete(group.get(), "measurement", H5P_DEFAULT), "measurement");
        const std::vector<double> none{5};
        h5::write<double>(group.get(), "measurement", none, {1}, "1");
    }
    test::expect_in(test::refusal([&] { read_finished(recorded::RecordingReader{file_}); }),
                    {"measured/overtones", "measurement 5"});
}

}  // namespace
}  // namespace shaker::recording
