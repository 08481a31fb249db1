#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <array>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>
#include <vector>

#include "daemon/remote/server.hpp"
#include "daemon/service/published.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/remote/played_bench.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::remote {
namespace {

using test::PlayedBench;
using test::TcpClient;

struct ScpiPortTest : testing::Test {
    PlayedBench bench;
    Server server{bench.bench_port, {.http_port = 0, .scpi_port = 0}};
    TcpClient client{server.scpi_port()};

    std::string ask(const std::string& line) { return client.ask(line); }
};

TEST_F(ScpiPortTest, AWholeRunByCommands) {
    EXPECT_EQ(ask("*IDN?").substr(0, 8), "shakerd,");
    EXPECT_EQ(ask("APPL:BIH 25,1G,0.4,30DEG;*OPC?"), "1");
    EXPECT_EQ(ask("FREQ?;:ACC?;:BIH:RHO?"), "2.50000000E+01;9.80000000E+00;4.00000000E-01");
    EXPECT_EQ(ask("OUTP ON;*OPC?"), "1");
    EXPECT_EQ(ask("OUTP?;:SYST:STAT?"), "1;\"run\"");
    EXPECT_EQ(ask("FETC:DRIF?").substr(0, 14), "1.45000000E-02");
    EXPECT_EQ(ask("FORM REAL,32;:FETC:VEL:CYCL?").substr(0, 5), "#3512");
    EXPECT_EQ(ask("FORM ASC;:OUTP OFF;*OPC?"), "1");
    EXPECT_EQ(ask("SYST:ERR?"), "0,\"No error\"");
}

TEST_F(ScpiPortTest, ReadReturnsNextMeasurement) {
    EXPECT_EQ(ask("READ?;:OUTP?").substr(0, 14), "1.45000000E-02");
    const std::string got = ask("MEAS? 25,2G;:FREQ?;:ACC?");
    EXPECT_EQ(got.substr(got.find(';')), ";2.50000000E+01;1.96000000E+01");
    EXPECT_EQ(ask("SYST:ERR?"), "0,\"No error\"");
}

TEST_F(ScpiPortTest, HealthReportsRefusedRealTime) {
    EXPECT_EQ(ask("SYST:HEAL?"),
              R"("dac",0,0,0,"accelerometer",0,0,0,"camera ""top""",0,0,0,"real time",2,1,0)");
    EXPECT_EQ(ask("SYST:HEAL:CONT?"), "\"open\"");
    EXPECT_EQ(ask("OUTP:ENAB?"), "1");
    EXPECT_EQ(ask("SYST:HEAL:RTIM?"), "\"output: cannot set real-time priority 70\"");
}

TEST_F(ScpiPortTest, ReadWithoutControlIsRefused) {
    TcpClient other{server.scpi_port()};
    EXPECT_EQ(other.ask("SYST:LOCK:REQ?"), "1");
    EXPECT_EQ(ask("READ?"), "9.91E37,9.91E37,9.91E37,0,0");
    EXPECT_EQ(ask("SYST:ERR?").substr(0, 5), "-203,");
    EXPECT_EQ(ask("OUTP?"), "0");
}

TEST_F(ScpiPortTest, AnAbortEndsARead) {
    bench.deaf = true;
    client.send("READ?");
    client.send("ABOR");
    for (int i = 0; i < 200 && bench.aborts == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
    bench.deaf = false;
    EXPECT_EQ(client.line(), "9.91E37,9.91E37,9.91E37,0,0");
    std::string told;
    for (int i = 0; i < 200 && !told.starts_with("-230,"); ++i) told = ask("SYST:ERR?");
    EXPECT_NE(told.find("stopped"), std::string::npos) << told;
}

TEST_F(ScpiPortTest, BusTriggerStartsInitiatedMeasurement) {
    EXPECT_EQ(ask("TRIG:SOUR BUS;SOUR?;*TRG;:SYST:ERR?").substr(0, 8), "BUS;-211");
    EXPECT_EQ(ask("READ?"), "9.91E37,9.91E37,9.91E37,0,0");
    EXPECT_EQ(ask("SYST:ERR?").substr(0, 5), "-214,");
    EXPECT_EQ(ask("INIT;*OPC?;:OUTP?"), "1;0");
    std::string bits;
    for (int i = 0; i < 200 && bits != "32"; ++i) {  // the registers are updated every 5 ms
        bits = ask("STAT:OPER:COND?");
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
    }
    EXPECT_EQ(bits, "32");
    EXPECT_EQ(ask("*TRG;*OPC?;:OUTP?"), "1;1");
    EXPECT_EQ(ask("*RST;*OPC?;:TRIG:SOUR?"), "1;IMM");
}

TEST_F(ScpiPortTest, AverageSettingsApplyToNextRun) {
    EXPECT_EQ(ask("AVER:SETT?;PER?"), "AUTO;40");
    EXPECT_EQ(ask("AVER:SETT 25;PER 60;:OUTP ON;*OPC?"), "1");
    EXPECT_EQ(ask("AVER:SETT?;PER?"), "25;60");
    const auto ordered = bench.ordered();
    ASSERT_EQ(ordered.size(), 1U);
    EXPECT_EQ(std::get<service::Begin>(ordered[0]).plan.settle, 25);
    EXPECT_EQ(std::get<service::Begin>(ordered[0]).plan.periods, 60);
}

TEST_F(ScpiPortTest, SettingsAreReadBackWhileOrdersWait) {
    bench.deaf = true;
    client.send("REC ON,\"walk\";:REC:RAW:CAM FULL;:CONT:LOOP OFF");
    EXPECT_EQ(ask("REC?;:REC:RAW:CAM?;:CONT:LOOP?"), "1;FULL;0");
    bench.deaf = false;
    EXPECT_EQ(ask("*OPC?;:REC?;:REC:RAW:CAM?;:CONT:LOOP?"), "1;1;FULL;0");
    const auto last = std::get<service::Record>(bench.ordered().at(1));
    EXPECT_TRUE(last.on) << "a later order keeps what an earlier one set";
    EXPECT_EQ(last.name, "walk");
}

TEST_F(ScpiPortTest, OvertonesSetTheDrive) {
    EXPECT_EQ(ask("FUNC?;:HARM1:AMPL?;:HARM2:AMPL 0.7;:BIH:RHO?"), "BIH;5.00000000E-01;3.00000000E-01");
    EXPECT_EQ(ask("HARM3:PHAS 1;:SYST:ERR?").substr(0, 4), "-221");
    EXPECT_EQ(ask("HARM3:AMPL 0.25;PHAS 90DEG;:FUNC?;:HARM3:AMPL?;PHAS?"),
              "MULT;2.50000000E-01;1.57079633E+00");
    EXPECT_EQ(ask("HARM9:AMPL 0.1;:SYST:ERR?").substr(0, 4), "-222");
    EXPECT_EQ(ask("FUNC BIH;FUNC?;:HARM3:AMPL?"), "BIH;0.00000000E+00");
}

TEST_F(ScpiPortTest, ARemarkGoesToTheLog) {
    EXPECT_EQ(ask("REC:NOTE 'new paper';*OPC?"), "1");
    const auto events = bench.bench_port.events(0);
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(events.back().text, "new paper");
}

TEST_F(ScpiPortTest, ARefusedOrderIsAnErrorOfItsSession) {
    EXPECT_EQ(ask("ACC 500;*OPC?"), "1");
    EXPECT_EQ(ask("SYST:ERR?").substr(0, 5), "-221,");
    EXPECT_EQ(ask("OUTP:PROT:CLE;*OPC?"), "1");
}

TEST_F(ScpiPortTest, EveryClientMayAbort) {
    TcpClient other{server.scpi_port()};
    EXPECT_EQ(ask("SYST:LOCK:REQ?"), "1");
    EXPECT_EQ(other.ask("SYST:LOCK:REQ?"), "0");
    other.send("OUTP ON");
    EXPECT_EQ(other.ask("SYST:ERR?").substr(0, 5), "-203,");
    EXPECT_EQ(bench.aborts, 0);
    EXPECT_EQ(other.ask("ABOR;*OPC?"), "1");
    EXPECT_EQ(bench.aborts, 1);
    EXPECT_EQ(ask("OUTP:PROT:TRIP?"), "1");
    std::string told;  // error of the other session after the next update
    for (int i = 0; i < 200 && !told.starts_with("101,"); ++i) told = ask("SYST:ERR?");
    EXPECT_TRUE(told.starts_with("101,\"Abort;")) << told;
}

TEST_F(ScpiPortTest, AbortOvertakesWaitingCommands) {
    bench.deaf = true;
    client.send("OUTP ON;*OPC?");
    client.send("ABOR");
    for (int i = 0; i < 200 && bench.aborts == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
    EXPECT_EQ(bench.aborts, 1);
    bench.deaf = false;
}

TEST_F(ScpiPortTest, CountMiddleAndFrictionAreOrders) {
    EXPECT_EQ(ask("TRIG:COUN?;:INIT:CONT?"), "INF;1");
    EXPECT_EQ(ask("TRIG:COUN 2;COUN?;:INIT:CONT?"), "2;0");
    EXPECT_EQ(ask("OUTP ON;*OPC?"), "1");
    const auto begun = bench.ordered().back();
    ASSERT_TRUE(std::holds_alternative<service::Begin>(begun));
    EXPECT_EQ(std::get<service::Begin>(begun).plan.measurements, 2);
    EXPECT_EQ(ask("OUTP OFF;:TRIG:COUN INF;COUN?;*OPC?"), "INF;1");
    EXPECT_EQ(ask("OUTP:MIDD;MIDD?;*OPC?"), "0;1");
    EXPECT_TRUE(std::holds_alternative<service::BringToMiddle>(bench.ordered().back()));
    EXPECT_EQ(ask("WALK:MU 0.113, 0.001;*OPC?"), "1");
    const auto given = bench.ordered().back();
    ASSERT_TRUE(std::holds_alternative<service::GiveMu>(given));
    EXPECT_EQ(std::get<service::GiveMu>(given).mu.value, 0.113);
    EXPECT_EQ(ask("SENS:CAM1:TARG:REG 'walker',40,20,180,170;*OPC?"), "1");
    const auto moved = bench.ordered().back();
    ASSERT_TRUE(std::holds_alternative<service::MoveTargets>(moved));
    EXPECT_EQ(text(std::get<service::MoveTargets>(moved).targets.at(0)),
              "camera \"top\", target \"walker\", roi_px = [40, 20, 180, 170]");
    EXPECT_EQ(ask("SENS:CAM1:TARG:CAT?"), "\"walker\",0,0,0,0");
    client.send("WALK:MU 9");
    EXPECT_NE(ask("SYST:ERR?").find("-222"), std::string::npos);
}

TEST_F(ScpiPortTest, ControlEndsWithTheConnection) {
    {
        TcpClient first{server.scpi_port()};
        EXPECT_EQ(first.ask("SYST:LOCK:REQ?"), "1");
        EXPECT_EQ(ask("SYST:LOCK:REQ?"), "0");
    }
    std::string got;
    for (int i = 0; i < 200 && got != "1"; ++i) got = ask("SYST:LOCK:REQ?");
    EXPECT_EQ(got, "1");
}

// ":STATus:OPERation[:EVENt]?/qonly/" with its optional parts, and the first number of "<1..4>".
std::string plain(std::string_view row) {
    std::string header;
    for (std::size_t i = 0; i < row.size(); ++i) {
        if (row[i] == '<')
            header += row[++i], i = row.find('>', i);
        else if (row[i] != '[' && row[i] != ']')
            header += row[i];
    }
    return header;
}

TEST_F(ScpiPortTest, LimitsOfRmsAndCoilAreLoweredAndRead) {
    EXPECT_EQ(ask("LIM:ACC:RMS:ABOR 0.5G;WARN 3;:LIM:COIL:ABOR 2500MA;WARN 2;*OPC?"), "1");
    EXPECT_EQ(ask("LIM:ACC:RMS:WARN?;ABOR?"), "3.00000000E+00;4.90000000E+00");
    EXPECT_EQ(ask("LIM:COIL:WARN?;ABOR?"), "2.00000000E+00;2.50000000E+00");
    EXPECT_EQ(ask("LIM:COIL:ABOR 1;WARN?;*OPC?"), "1.00000000E+00;1")
        << "a warning level is at most its abort level";
    EXPECT_EQ(ask("SYST:ERR?"), "0,\"No error\"");
    const auto limits = bench.bench_port.state()->limits;
    EXPECT_EQ(limits.acceleration_rms, (safety::Level{3, 4.9}));
    EXPECT_EQ(limits.coil_A, (safety::Level{1, 1}));
    EXPECT_EQ(limits.acceleration, (safety::Level{40, 50}));
}

TEST_F(ScpiPortTest, ScpiPageHasEveryHeader) {
    std::ifstream in{test::source_dir() + "/daemon/remote/SCPI.md"};
    const std::string page{std::istreambuf_iterator<char>{in}, {}};
    client.send("SYST:HELP:HEAD?");
    std::istringstream list{client.block()};
    int found = 0;
    for (std::string row; std::getline(list, row);) {
        std::string header =
            row.substr(row.find_first_not_of(':'), row.find_first_of("?/") - row.find_first_not_of(':'));
        if (header.starts_with('*') || header.starts_with("STATus")) continue;
        ++found;
        EXPECT_NE(page.find('`' + header), std::string::npos) << header;
    }
    EXPECT_GT(found, 60);
    for (const service::Published& row : service::published_quantities()) {
        if (row.header == nullptr) continue;
        const std::string line = fmt::format("| `{}?` | {}", row.header, row.text());
        EXPECT_NE(page.find(line), std::string::npos) << line;
    }
}

// Every setting accepts the answer of its query, and every command without a query is accepted, so no listed
// header is missing.
TEST_F(ScpiPortTest, EverySettingAcceptsItsOwnAnswer) {
    client.send("SYST:HELP:HEAD?");
    std::istringstream list{client.block()};
    int set = 0;
    for (std::string row; std::getline(list, row);) {
        const std::string header = plain(row.substr(0, row.find_first_of("?/")));
        if (row.find("/qonly/") != std::string::npos) continue;
        ++set;
        std::string value;
        if (row.find("/nquery/") == std::string::npos && header != "*OPC" && header != ":ABORt" &&
            header != ":OUTPut:MIDDle") {
            value = ask("*CLS;" + header + "?");
        } else if (header == "*SAV" || header == "*RCL") {
            value = "1";
        } else if (header.ends_with("RECord:NOTE")) {
            value = "'new paper'";
        } else if (header.ends_with("TARGet:REGion")) {
            value = "'walker',1,2,30,40";
        } else if (header.ends_with("WALKer:MU")) {
            value = "0.113";
        } else if (header.ends_with("CAMPaign:STARt") || header.ends_with("CAMPaign:CHECk")) {
            value = "'fig3'";
        } else if (header.ends_with("CAMPaign:SCAN")) {
            value = "PHI,0,1,3";
        } else if (header.ends_with("PASSword:CENable")) {
            value = "''";
        }
        client.send("*CLS;" + header + (value.empty() ? "" : " " + value));
        std::string told = ask("SYST:ERR?");
        EXPECT_FALSE(told.starts_with("-1") || told.starts_with("-222") || told.starts_with("-224"))
            << header << ' ' << value << ": " << told;
        client.send("OUTP OFF;:OUTP:PROT:CLE;*CLS");
    }
    EXPECT_GT(set, 25);
}

// Each query gives exactly one line, in idle without a result and while measuring, so no client waits in
// vain.
TEST_F(ScpiPortTest, EveryQueryAnswersExactlyOneLine) {
    client.send("SYST:HELP:HEAD?");
    const std::string list = client.block();
    TcpClient other{server.scpi_port()};
    for (const char* before : {"*WAI", "OUTP ON;*WAI"}) {
        client.send(before);
        other.ask("SYST:LOCK:REQ?");  // so that READ? and MEASure? are refused
        std::istringstream rows{list};
        int queries = 0;
        for (std::string row; std::getline(rows, row);) {
            std::string header = plain(row.substr(0, row.find_first_of("?/")));
            if (row.find("/nquery/") != std::string::npos || header == ":SYSTem:HELP:HEADers") continue;
            if (header == ":ABORt") continue;  // trips the bench
            header += "?";
            ++queries;
            client.send("*CLS;" + header);
            client.send("SYST:ERR?");
            const std::string answer = client.line(), error = client.line();
            EXPECT_FALSE(answer.empty()) << header;
            EXPECT_TRUE(error.starts_with("0,") || error.starts_with("-2")) << header << ": " << error;
        }
        EXPECT_GT(queries, 70);
        other.ask("SYST:LOCK:REL;*OPC?");
    }
}

TEST_F(ScpiPortTest, QueryWithoutResultAnswersNanInItsShape) {
    const std::string nan = "9.91E37", two = nan + "," + nan;
    const std::vector<std::array<std::string, 3>> cases{{"FETC:DRIF?", two + "," + nan + ",0,0", "-230"},
                                                        {"FETC:EFF?", two, "-230"},
                                                        {"FETC:MIRR?", two + "," + two, "-230"},
                                                        {"FETC:THET?", two + ",NULL", "-230"},
                                                        {"FETC:MU?", two + ",COULOMB", "-230"},
                                                        {"FETC:VEL:CYCL?", nan, "-230"},
                                                        {"FETC:WALK:POS?", two, "-230"},
                                                        {"CONT:IDEN:RES?", nan, "-230"},
                                                        {"SENS:CAM1:QUAL?", nan, "-230"},
                                                        {"SENS:CAM2:FRAM?", two, "-241"}};
    for (const auto& [query, answer, error] : cases) {
        EXPECT_EQ(ask(query), answer) << query;
        EXPECT_EQ(ask("SYST:ERR?").substr(0, 4), error) << query;
    }
}

TEST_F(ScpiPortTest, AMuThatTheMeasurementsRefuseIsNamedSo) {
    bench.mu_refused = true;
    std::string told;
    for (int i = 0; i < 200 && !told.ends_with("REFUSED"); ++i) {
        told = ask("FETC:MU?");
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
    }
    EXPECT_EQ(told, "8.30000000E-02,1.00000000E-05,REFUSED");
}

}  // namespace
}  // namespace shaker::remote
