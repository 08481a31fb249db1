// The table of results: order, bounds, and its rows as JSON and CSV.
#include "daemon/catalogue/results_table.hpp"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/catalogue/recording_summary.hpp"
#include "daemon/catalogue/row_text.hpp"
#include "daemon/recording/time_text.hpp"
#include "daemon/reduction/series.hpp"
#include "drivers/errors.hpp"

namespace shaker::catalogue {
namespace {

using nlohmann::json;

ResultRow row_at(const std::string& time) {
    ResultRow row;
    row.time = time;
    row.asked = Drive{.frequency = 20, .gamma = 9.8, .rho = 0.5, .phi = 1.75};
    row.asked->overtones[0] = {0.01, 0.02};
    row.periods = 20;
    row.v_D = {0.0065995, 5.8e-7};
    row.steady = true;
    row.notes = "a \"note\", with a comma";
    row.ended = "complete";
    row.recording = "first.nxs";
    return row;
}

std::vector<std::string> times(const std::vector<NumberedRow>& rows) {
    std::vector<std::string> all;
    for (const NumberedRow& r : rows) all.push_back(r.row.time);
    return all;
}

TEST(ResultsTableTest, RowsAreInOrderOfTimeAndNumberedByArrival) {
    ResultsTable table;
    table.add({row_at("2026-11-26T10:00:00Z"), row_at("2026-11-26T12:00:00Z")});
    table.add({row_at("2026-11-25T09:00:00Z"), row_at("2026-11-26T11:00:00Z")});
    EXPECT_EQ(times(table.since(0)),
              (std::vector<std::string>{"2026-11-25T09:00:00Z", "2026-11-26T10:00:00Z",
                                        "2026-11-26T11:00:00Z", "2026-11-26T12:00:00Z"}));
    EXPECT_EQ(times(table.since(2)),
              (std::vector<std::string>{"2026-11-25T09:00:00Z", "2026-11-26T11:00:00Z"}));
    EXPECT_EQ(table.newest(), 4U);
    EXPECT_TRUE(table.since(4).empty());
}

TEST(ResultsTableTest, EarliestRowsAreDroppedBeyondTheLimit) {
    ResultsTable table;
    table.add(std::vector<ResultRow>(ResultsTable::most_rows, row_at("2026-11-26T10:00:00Z")));
    table.add({row_at("2026-11-25T09:00:00Z"), row_at("2026-11-26T11:00:00Z")});
    const std::vector<NumberedRow> rows = table.since(0);
    EXPECT_EQ(rows.size(), ResultsTable::most_rows);
    EXPECT_EQ(rows.front().row.time, "2026-11-26T10:00:00Z");
    EXPECT_EQ(rows.back().row.time, "2026-11-26T11:00:00Z");
}

TEST(ResultsTableTest, RowComesBackFromItsJson) {
    const ResultRow row = row_at("2026-11-26T10:00:00Z");
    EXPECT_EQ(json_of(row_from(json::parse(json_of(row).dump()))), json_of(row));
    EXPECT_EQ(json_of(row)["gamma_mps2"], nullptr) << "not known";
    const ResultRow interrupted = interrupted_row({}, "stopped");
    EXPECT_EQ(json_of(row_from(json::parse(json_of(interrupted).dump()))).dump(),
              json_of(interrupted).dump());
}

TEST(ResultsTableTest, HostileSummaryBecomesUnknownValues) {
    for (const char* text :
         {"[]", "3", "null", "{}", R"({"results":3,"remarks":{"a":1},"measurements":-1e300})",
          R"({"results":[1,null,{"asked":3,"v_D_mps":[1],"time":{"a":1},"steady":"yes"}]})",
          R"({"results":[{"asked":{"overtones":[{"n":1e9,"share":1,"phase_rad":0},7]}}]})"}) {
        for (const ResultRow& row : summary_from(text).rows) {
            EXPECT_EQ(row.time, "") << text;
            EXPECT_TRUE(std::isnan(row.v_D.value)) << text;
            EXPECT_FALSE(row.steady) << text;
        }
    }
    EXPECT_THROW(static_cast<void>(summary_from("{\"results\":[")), InputError);
    const RecordingSummary s = summary_from(json{
        {"title", std::string(5000, 'x') + "\x1b"},
        {"outcome", "a\x1b[31mb"},
        {"results", std::vector<int>(5000, 1)}}.dump());
    EXPECT_EQ(s.title.size(), 500U);
    EXPECT_EQ(s.outcome, "a\\x1b[31mb");
    EXPECT_EQ(s.rows.size(), RecordingSummary::most_rows);
}

TEST(ResultsTableTest, CsvHasUnitsQuotesAndEmptyUnknownValues) {
    ResultsTable table;
    table.add({row_at("2026-11-26T10:00:00Z")});
    const std::string csv = results_csv(table.since(0));
    EXPECT_NE(csv.find("v_D [m/s],v_D_errors [m/s],"), std::string::npos) << csv;
    EXPECT_NE(csv.find("\r\n2026-11-26T10:00:00Z,20,9.8000000000000007,0.5,1.75,\"3: 0.0223"),
              std::string::npos)
        << csv;
    EXPECT_NE(csv.find(",20,,,,,,,0.0065995"), std::string::npos) << csv;
    EXPECT_NE(csv.find(R"(,1,"complete","a ""note"", with a comma","first.nxs")"), std::string::npos) << csv;
}

TEST(ResultsTableTest, ShortMeasurementIsNotComplete) {
    const recording::FinishedMeasurement m{.number = 1, .asked = {}, .part = {1, 1.65}, .time = {}};
    const reduction::Reduction some;
    EXPECT_EQ(row_of(m, &some, {}, 20).ended, "ended after 13 of 20 periods");
    EXPECT_EQ(row_of(m, &some, {}, 13).ended, "complete");
    EXPECT_EQ(row_of(m, nullptr, "no walker", 20).ended, "no result: no walker");
}

TEST(ResultsTableTest, TimesAreInUtc) {
    EXPECT_EQ(recording::utc_text("2026-11-26T01:30:00+02:00"), "2026-11-25T23:30:00Z");
    EXPECT_EQ(recording::utc_text("yesterday"), "");
}

TEST(RepeatsTest, SteadyRowsOfOneSetPointAreCombinedAsPasses) {
    std::vector<NumberedRow> rows;
    std::vector<reduction::PassDrift> passes;
    for (const double v : {1.0, 1.2, 1.1}) {
        ResultRow row = row_at(fmt::format("2026-11-26T10:00:0{}Z", rows.size()));
        row.v_D = {v, 0.05};
        row.D = {v / 20, 0.05 / 20};
        passes.push_back({row.v_D, 20});
        rows.push_back({rows.size() + 1, row});
    }
    ResultRow unsteady = row_at("2026-11-26T11:00:00Z"), other = unsteady, unknown = unsteady,
              none = unsteady, no_error = unsteady;
    unsteady.v_D.value = 7;
    unsteady.steady = false;
    other.asked->overtones[0] = 0;
    unknown.asked.reset();
    none.v_D = {};
    no_error.v_D.sigma = INFINITY;
    for (const ResultRow& row : {unsteady, other, unknown, none, no_error})
        rows.push_back({rows.size() + 1, row});
    const std::vector<Repeats> all = repeats_of(rows);
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[0].asked, *other.asked) << "the newest first";
    EXPECT_EQ(all[0].count, 1);
    EXPECT_TRUE(std::isnan(all[0].scatter));
    const Repeats& three = all[1];
    EXPECT_EQ(three.count, 3);
    EXPECT_EQ(three.newest, "2026-11-26T10:00:02Z");
    const calibration::Estimate mean = reduction::combined(passes).v_D;
    EXPECT_EQ(three.v_D.value, mean.value);
    EXPECT_EQ(three.v_D.sigma, mean.sigma);
    EXPECT_NEAR(three.D.value, mean.value / 20, 1e-12);
    EXPECT_NEAR(three.stated, 0.05, 1e-12);
    EXPECT_NEAR(three.scatter, 0.1, 1e-12);
    const json text = json::parse(repeats_json(all))["repeats"];
    EXPECT_TRUE(text[0]["scatter_mps"].is_null());
    EXPECT_EQ(text[1]["v_D_mps"]["sigma"], mean.sigma);
}

}  // namespace
}  // namespace shaker::catalogue
