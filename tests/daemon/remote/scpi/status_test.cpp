// Status registers by IEEE 488.2 chapter 11 and SCPI-99 volume 1, chapter 5.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/remote/scpi_client.hpp"

namespace shaker::scpi {
namespace {

class ScpiStatusTest : public testing::Test {
protected:
    test::ScpiBench bench_;
    test::ScpiClient client_{bench_};
};

TEST_F(ScpiStatusTest, MasksReadBackAndTheServiceMaskHasNoBitSix) {
    EXPECT_EQ(client_.ask("*ESE 255;*ESE?;*SRE 255;*SRE?"), "255;191\n");
    EXPECT_EQ(client_.ask("STAT:OPER:ENAB 65535;ENAB?;PTR #H00FF;PTR?;NTR 65535;NTR?"), "32767;255;32767\n");
    EXPECT_EQ(client_.ask("STAT:PRES;OPER:ENAB?;PTR?;NTR?"), "0;32767;0\n");
    EXPECT_EQ(client_.ask("STAT:QUES:ENAB?;PTR?;NTR?"), "0;32767;0\n");
    EXPECT_EQ(client_.ask("*ESE?;*SRE?"), "255;191\n");
}

TEST_F(ScpiStatusTest, StatusByteSummarisesEnabledEvents) {
    client_.ask("*CLS");
    EXPECT_EQ(client_.ask("*STB?"), "0\n");
    client_.ask("FREK");
    EXPECT_EQ(client_.ask("*STB?"), "4\n");
    EXPECT_EQ(client_.ask("*ESE 32;*STB?"), "36\n");
    EXPECT_EQ(client_.ask("*SRE 32;*STB?"), "100\n");
    EXPECT_EQ(client_.ask("*SRE 4;*STB?"), "100\n");
    EXPECT_EQ(client_.ask("*SRE 8;*STB?"), "36\n");
    EXPECT_EQ(client_.ask("*ESR?"), "32\n");
    EXPECT_EQ(client_.ask("*STB?"), "4\n");
    client_.error();
    EXPECT_EQ(client_.ask("*STB?"), "0\n");
    EXPECT_EQ(client_.ask("*IDN?;*STB?"), "maker,model,1,0.1;16\n");
    client_.session.feed("*IDN?\n*STB?\n");
    EXPECT_EQ(client_.read(), "maker,model,1,0.1\n16\n");
}

TEST_F(ScpiStatusTest, ConditionsMakeEventsThatStayUntilRead) {
    bench_.status.set(Operation::settling, true);
    EXPECT_EQ(client_.ask("STAT:OPER:COND?;EVEN?;EVEN?;COND?"), "2;2;0;2\n");
    bench_.status.set(Operation::settling, false);
    EXPECT_EQ(client_.ask("STAT:OPER:COND?;:STAT:OPER?"), "0;0\n");
}

TEST_F(ScpiStatusTest, ShortConditionIsAnEvent) {
    bench_.status.set(Questionable::data_loss, true);
    bench_.status.set(Questionable::data_loss, false);
    EXPECT_EQ(client_.ask("STAT:QUES:COND?;EVEN?"), "0;2048\n");
}

TEST_F(ScpiStatusTest, FiltersSelectEvents) {
    client_.ask("STAT:OPER:PTR 0;NTR 256");
    bench_.status.set(Operation::output_on, true);
    bench_.status.set(Operation::recording, true);
    EXPECT_EQ(client_.ask("STAT:OPER?"), "0\n");
    bench_.status.set(Operation::output_on, false);
    bench_.status.set(Operation::recording, false);
    EXPECT_EQ(client_.ask("STAT:OPER?"), "256\n");
}

TEST_F(ScpiStatusTest, AFilterActsOnLaterChangesOnly) {
    client_.ask("STAT:OPER:PTR 0");
    bench_.status.set(Operation::output_on, true);
    client_.ask("STAT:OPER:PTR 256");
    EXPECT_EQ(client_.ask("STAT:OPER?"), "0\n");
    client_.ask("STAT:OPER:PTR 256");
    bench_.status.set(Operation::output_on, false);
    bench_.status.set(Operation::output_on, true);
    client_.ask("STAT:OPER:PTR 0");
    EXPECT_EQ(client_.ask("STAT:OPER?"), "256\n");
}

TEST_F(ScpiStatusTest, EnabledEventsReachTheStatusByte) {
    client_.ask("*CLS;:STAT:OPER:ENAB 256;:STAT:QUES:ENAB 512");
    bench_.status.set(Operation::output_on, true);
    EXPECT_EQ(client_.ask("*STB?"), "128\n");
    bench_.status.set(Questionable::abort_latched, true);
    EXPECT_EQ(client_.ask("*STB?"), "136\n");
    client_.ask("STAT:OPER?;QUES?");
    EXPECT_EQ(client_.ask("*STB?"), "0\n");
}

TEST_F(ScpiStatusTest, ClearKeepsMasks) {
    client_.ask("*ESE 5;*SRE 6;:STAT:OPER:ENAB 7;PTR 8;NTR 9;:FREK");
    bench_.status.set(Operation::sweeping, true);
    client_.ask("*CLS");
    EXPECT_EQ(client_.ask("STAT:OPER:EVEN?;ENAB?;PTR?;NTR?;COND?"), "0;7;8;9;8\n");
    EXPECT_EQ(client_.ask("*ESE?;*SRE?;*ESR?"), "5;6;0\n");
    EXPECT_EQ(client_.error(), "0,\"No error\"");
}

TEST_F(ScpiStatusTest, EachClientHasItsOwnEvents) {
    test::ScpiClient other{bench_};
    bench_.status.set(Operation::output_on, true);
    EXPECT_EQ(client_.ask("STAT:OPER?"), "256\n");
    EXPECT_EQ(other.ask("STAT:OPER?"), "256\n");
    test::ScpiClient late{bench_};
    EXPECT_EQ(late.ask("STAT:OPER:EVEN?;COND?"), "0;256\n");
}

TEST_F(ScpiStatusTest, CommonCommandsReachTheInstrument) {
    client_.ask("*RST;*TRG;*SAV 3;*RCL 9");
    EXPECT_EQ(bench_.instrument.told, (std::vector<std::string>{"reset", "trigger", "save 3", "recall 9"}));
    EXPECT_EQ(client_.ask("*IDN?;*OPT?;*TST?;:SYST:VERS?"), "maker,model,1,0.1;0;0;1999.0\n");
    client_.ask("*SAV 10");
    EXPECT_TRUE(client_.error().starts_with("-222"));
}

}  // namespace
}  // namespace shaker::scpi
