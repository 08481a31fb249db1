// *OPC, *OPC? and *WAI make a client wait. ABORt never waits.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/remote/scpi_client.hpp"

namespace shaker::scpi {
namespace {

class ScpiWaitingTest : public testing::Test {
protected:
    std::string done() {
        bench_.instrument.busy = false;
        client_.session.poll();
        return client_.read();
    }
    test::ScpiBench bench_;
    test::ScpiClient client_{bench_};
    std::vector<std::string>& told_ = bench_.instrument.told;
};

TEST_F(ScpiWaitingTest, NothingWaitsForAnInstrumentThatIsDone) {
    EXPECT_EQ(client_.ask("*WAI;*OPC?;*ESR?;*OPC;*ESR?"), "1;128;1\n");
    EXPECT_FALSE(client_.session.waiting());
}

TEST_F(ScpiWaitingTest, OpcReplyAndFollowingInputAreWithheld) {
    EXPECT_EQ(client_.ask("*TST?;:INIT;*OPC?;:FREQ 33;FREQ?"), "");
    EXPECT_EQ(client_.ask("FREQ?"), "");
    client_.session.poll();
    EXPECT_EQ(client_.read(), "");
    EXPECT_EQ(bench_.frequency, 20);
    EXPECT_EQ(done(), "0;1;3.30000000E+01\n3.30000000E+01\n");
}

TEST_F(ScpiWaitingTest, WaiWithholdsWithoutAReplyAndMayWaitAgain) {
    client_.ask("INIT;*WAI;:OUTP ON;:INIT;*WAI;:OUTP OFF");
    client_.ask("*OPC?");
    EXPECT_TRUE(told_.empty());
    EXPECT_EQ(done(), "");
    EXPECT_EQ(told_, std::vector<std::string>{"on"});
    EXPECT_TRUE(client_.session.waiting());
    EXPECT_EQ(done(), "1\n");
    EXPECT_EQ(told_, (std::vector<std::string>{"on", "off"}));
}

TEST_F(ScpiWaitingTest, OpcSetsItsBitWhenTheInstrumentIsDone) {
    EXPECT_EQ(client_.ask("*CLS;:INIT;*OPC;*ESR?"), "0\n");
    done();
    EXPECT_EQ(client_.ask("*ESR?"), "1\n");
    EXPECT_EQ(client_.ask("*ESR?"), "0\n");
}

TEST_F(ScpiWaitingTest, ClearAndResetForgetOpc) {
    for (const char* forget : {"*CLS", "*RST"}) {
        client_.ask("INIT;*OPC");
        client_.ask(forget);
        client_.ask("*ESR?");
        done();
        EXPECT_EQ(client_.ask("*ESR?"), "0\n") << forget;
    }
}

TEST_F(ScpiWaitingTest, OtherClientsDoNotWait) {
    test::ScpiClient other{bench_};
    client_.ask("INIT;*WAI");
    EXPECT_EQ(other.ask("FREQ?"), "2.00000000E+01\n");
}

TEST_F(ScpiWaitingTest, AbortAfterWaitRunsAtOnceAndDropsInput) {
    bench_.instrument.abort_ends_it = false;
    client_.ask("INIT;*OPC?;:OUTP ON");
    client_.ask("OUTP ON;:FREQ 33");
    client_.ask("OUTP ON;:aBoRt;:FREQ 44");
    EXPECT_EQ(told_, std::vector<std::string>{"abort"});
    EXPECT_EQ(done(), "1\n");
    EXPECT_EQ(told_, std::vector<std::string>{"abort"});
    EXPECT_EQ(bench_.frequency, 44);
    EXPECT_EQ(client_.error(), "-200,\"Execution error;1 messages before ABORt were dropped\"");
    EXPECT_EQ(client_.error(), "-200,\"Execution error;2 messages before ABORt were dropped\"");
}

TEST_F(ScpiWaitingTest, AbortInWaitingMessageRunsAtOnce) {
    for (const char* message : {"INIT;*WAI;:ABOR;:FREQ 44", "INIT;*OPC?;FREK;ABOR;:FREQ 44",
                                "INIT;*WAI;LIM:ACC:WARN 3;:ABOR;FREQ 44"}) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        bench.instrument.abort_ends_it = false;
        client.ask(message);
        EXPECT_EQ(bench.last_told(), "abort") << message;
        EXPECT_EQ(bench.frequency, 20) << message;
        bench.instrument.busy = false;
        client.session.poll();
        EXPECT_EQ(bench.frequency, 44) << message;
        EXPECT_EQ(bench.instrument.told.size(), 1U) << message;
    }
}

TEST_F(ScpiWaitingTest, OtherHeadersEndingInAbortDoNotAbort) {
    client_.ask("INIT;*WAI;:LIM:ACC:WARN 3;ABOR 5");
    client_.ask("LIM:ACC:ABOR 5");
    client_.ask("REC:NOTE ';ABOR;'");
    client_.ask("ARB:DATA #16;ABOR;");
    EXPECT_TRUE(told_.empty());
    done();
    EXPECT_EQ(told_, (std::vector<std::string>{"abort level", "abort level"}));
}

TEST_F(ScpiWaitingTest, AbortByOtherClientDropsWithheldInput) {
    client_.ask("INIT;*OPC?;:OUTP ON");
    client_.ask("OUTP ON");
    client_.session.drop_withheld();
    EXPECT_EQ(done(), "1\n");
    EXPECT_TRUE(told_.empty());
    EXPECT_TRUE(client_.error().starts_with("-200,"));
}

TEST_F(ScpiWaitingTest, WithheldInputIsBoundedAndAbortPasses) {
    client_.ask("INIT;*WAI");
    const std::string note = "REC:NOTE '" + std::string(1000, 'x') + "'";
    for (int i = 0; i < 200; ++i) client_.ask(note);
    client_.ask("ABOR");
    EXPECT_EQ(bench_.last_told(), "abort");
    done();
    EXPECT_TRUE(client_.error().starts_with(
        "-363,\"Input buffer overrun;more than 65536 bytes received during a wait"));
}

TEST(ScpiAbortTest, AbortQueryAnswersWhenTheOutputObeys) {
    using Answer = access::Aborts::Answer;
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    bench.instrument.abort_answer = Answer::none;
    EXPECT_EQ(client.ask("ABOR?;FREQ?"), "");
    EXPECT_EQ(bench.last_told(), "abort");
    EXPECT_EQ(client.ask("*TST?"), "");
    bench.instrument.abort_answer = Answer::obeyed;
    client.session.poll();
    EXPECT_EQ(client.read(), "1;2.00000000E+01\n0\n");
    bench.instrument.abort_answer = Answer::silent;
    client.ask("ABOR?");
    client.session.poll();
    EXPECT_EQ(client.read(), "0\n");
    EXPECT_EQ(client.error(), "113,\"Abort not obeyed;the output does not answer: cut the amplifier\"");
}

TEST(ScpiAbortTest, AbortQueryDuringAWaitAnswersAfterIt) {
    test::ScpiBench bench;
    bench.instrument.busy = true;
    bench.instrument.abort_ends_it = false;
    test::ScpiClient client{bench};
    EXPECT_EQ(client.ask("*OPC?"), "");
    EXPECT_EQ(client.ask("OUTP ON"), "");
    EXPECT_EQ(client.ask("ABOR?"), "");
    EXPECT_EQ(client.ask("FREQ?"), "");
    EXPECT_EQ(bench.instrument.told, std::vector<std::string>{"abort"}) << "at once";
    bench.instrument.busy = false;
    client.session.poll();
    EXPECT_EQ(client.read(), "1\n1\n2.00000000E+01\n");
    EXPECT_EQ(bench.instrument.told.size(), 1U) << "once, and what was withheld before it is dropped";
}

TEST(ScpiAbortTest, UnobeyedAbortIsReportedOnce) {
    test::ScpiBench bench;
    bench.instrument.abort_answer = access::Aborts::Answer::silent;
    test::ScpiClient client{bench};
    client.ask("ABOR;ABOR");
    client.session.poll();
    client.session.poll();
    EXPECT_EQ(client.error().substr(0, 4), "113,");
    EXPECT_EQ(client.error(), "0,\"No error\"");
}

}  // namespace
}  // namespace shaker::scpi
