// The report and the other files of a run, as their owner and others get them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "tests/server/report/pdf_reader.h"
#include "tests/support/paths.h"
#include "tests/system/contract/contract_world.h"

namespace faultlab::tests {
namespace {

namespace json = boost::json;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class ReportApiTest : public ContractWorld {
 protected:
  std::string Run(const std::string& who, const std::string& body) {
    const json::object run = Expect(201, who, "POST runs", body);
    std::string id(run.at("id").as_string());
    WaitForRun(id);
    return id;
  }
  HttpAnswer File(const std::string& who, const std::string& id, const std::string& file) {
    return Call(who, "GET runs/" + id + "/" + file);
  }

  json::value StoryOf(const std::string& id);
};

TEST_F(ReportApiTest, ReportsARunToWhoeverMayReadIt) {
  const std::string id = Run(
      "ann",
      R"({"duration_s":8,"name":"Čas 1/2","faults":[{"component":"R1","value":100,"at_s":6}]})");
  const HttpAnswer report = File("ann", id, "report.pdf");
  ASSERT_EQ(report.status, 200);
  EXPECT_EQ(report.Header("Content-Type"), "application/pdf");
  EXPECT_THAT(report.Header("Content-Disposition"), StartsWith("inline; filename=\"20"));
  EXPECT_THAT(report.Header("Content-Disposition"), HasSubstr("_%C4%8Cas-1-2_report.pdf"));
  PdfReader pdf(report.body);
  const std::string text = pdf.Text();
  EXPECT_EQ(pdf.Pages(), 3);
  EXPECT_THAT(text, HasSubstr(Squeezed("Made by ann")));
  EXPECT_THAT(text, HasSubstr(Squeezed("PRBS: low 2 V, high 3 V, clock 0.01 s")));
  EXPECT_THAT(text, HasSubstr(Squeezed("Fault: R1")));
  EXPECT_THAT(text, HasSubstr(Squeezed("6.00 600 R1 100 Ω confirmed")));
  EXPECT_GT(pdf.Coloured(2), 0.002);
  EXPECT_GT(pdf.Coloured(3), 0.002);
  EXPECT_TRUE(File("ann", id, "report.pdf").body == report.body) << "same bytes";
  EXPECT_TRUE(File("operator", id, "report.pdf").body == report.body);
  EXPECT_EQ(File("bob", id, "report.pdf").status, 404);
  EXPECT_EQ(File("guest", id, "report.pdf").status, 401);
  EXPECT_EQ(File("ann", id, "report.pdf?language=de").status, 400);
}

/// With numbers as numbers: CSV files write 8 for 8E0.
json::value Plain(const json::value& value) {
  if (value.is_number()) return value.to_number<double>();
  if (const json::array* list = value.if_array()) {
    json::array out;
    for (const json::value& each : *list) out.push_back(Plain(each));
    return out;
  }
  if (const json::object* object = value.if_object()) {
    json::object out;
    for (const auto& [name, member] : *object) out[name] = Plain(member);
    return out;
  }
  return value;
}

/// The story of a run as REST, list, files and report tell it. @returns that of REST
json::value ReportApiTest::StoryOf(const std::string& id) {
  const json::object run = Expect(200, "ann", "GET runs/" + id);
  json::value story = Plain(run.at("story"));
  const json::object list = Expect(200, "ann", "GET runs");
  EXPECT_EQ(list.at("items").at(0).at("id"), json::value(id));
  if (story.at("changes").as_array().size() <= 8) {  // of more a list has the newest
    EXPECT_EQ(Plain(list.at("items").at(0).at("story")), story) << "the list";
  }
  const std::string whole = File("ann", id, "export.json").body;
  EXPECT_EQ(Plain(json::parse(whole).at("story")), story);
  const std::string csv = File("ann", id, "export.csv").body;
  const std::size_t line = csv.find("# story ") + 8;
  EXPECT_EQ(Plain(json::parse(csv.substr(line, csv.find('\n', line) - line))), story) << "the CSV";
  const std::size_t from = whole.find("\"story\":") + 8;
  std::string wide;  // as MATLAB has texts
  for (const char letter : whole.substr(from, whole.find(",\"diagnosis\":") - from)) {
    wide.append({letter, '\0'});
  }
  EXPECT_NE(File("ann", id, "export.mat").body.find(wide), std::string::npos) << "the MAT file";
  const std::string text = PdfReader(File("ann", id, "report.pdf").body).Text();
  for (const json::value& each : story.at("episodes").as_array()) {
    const json::object* finding = each.at("finding").if_object();
    if (finding == nullptr || finding->at("verdict") != "fault") continue;
    for (const json::value& named : finding->at("candidates").as_array()) {
      EXPECT_THAT(text, HasSubstr(server::Text(named, "component")));
    }
  }
  return story;
}

TEST_F(ReportApiTest, TellsOneStoryInEveryPlace) {
  const std::string id = Run("ann",
                             R"({"duration_s":16,"faults":[{"component":"R9","value":33000,)"
                             R"("at_s":8,"kind":"intermittent","until_s":12}]})");
  const json::value story = StoryOf(id);
  ASSERT_EQ(story.at("episodes").as_array().size(), 1U) << story;
  const json::object& episode = story.at("episodes").at(0).as_object();
  EXPECT_EQ(episode.at("onset_s"), 8.0);
  EXPECT_EQ(episode.at("ended_s"), 12.0);
  EXPECT_EQ(episode.at("changes").at(0).at("value"), 33e3);
  EXPECT_EQ(episode.at("detections").at(0).at("of"), "first");
  EXPECT_EQ(episode.at("detections").as_array().back().at("of"), "return");
  EXPECT_EQ(episode.at("finding").at("candidates").as_array().size(), 2U) << "a group is one";
  EXPECT_EQ(story.at("change_times_s"), (json::array{8.0, 12.0}));
  const std::string text = PdfReader(File("ann", id, "report.pdf").body).Text();
  EXPECT_THAT(text, HasSubstr(Squeezed("Fault: R9 or R12")));
  EXPECT_THAT(text, HasSubstr(Squeezed("until 12.00 s")));
  EXPECT_THAT(text, HasSubstr(Squeezed("R9 = 33")));
}

TEST_F(ReportApiTest, TellsTheStoryOfOddRunsInEveryPlaceToo) {
  const json::value short_one = StoryOf(Run("ann", R"({"duration_s":2})"));
  EXPECT_EQ(short_one.at("episodes").as_array().size(), 0U);
  std::string faults;  // three parts, ten switchings, one after the other
  const std::array<const char*, 3> kParts = {
      R"("R9","value":33000)", R"("R1","value":100)", R"("R12","value":15000)"};
  for (int k = 0; k < 10; ++k) {
    faults += std::string(k == 0 ? "" : ",") + R"({"component":)" +
              kParts[static_cast<std::size_t>(k % 3)] + R"(,"kind":"intermittent","at_s":)" +
              std::to_string(8 + 3 * k) + R"(,"until_s":)" + std::to_string(10 + 3 * k) + "}";
  }
  const json::value switched =
      StoryOf(Run("ann", R"({"duration_s":40,"faults":[)" + faults + "]}"));
  EXPECT_EQ(switched.at("episodes").as_array().size(), 10U);
  EXPECT_EQ(switched.at("changes").as_array().size(), 20U);

  const json::object run = Expect(201, "ann", "POST runs", R"({"duration_s":600,"faults":[
                                              {"component":"R1","value":100,"at_s":599}]})");
  const std::string id = server::Id(run);
  Expect(202, "ann", "POST runs/" + id + "/stop", "{}");
  WaitForRun(id);
  EXPECT_EQ(StoryOf(id).at("changes").as_array().size(), 0U) << "stopped in its healthy part";
}

TEST_F(ReportApiTest, NamesTheChecksumOfTheCsvThatIsDownloaded) {
  const std::string id = Run("ann", R"({"duration_s":3})");
  const HttpAnswer csv = File("ann", id, "export.csv");
  EXPECT_THAT(csv.body, HasSubstr("\"clock_s\":0.01"));
  EXPECT_THAT(csv.body.substr(0, csv.body.find("t_s,uc_v")), Not(HasSubstr("E-")));
  TempFolder folder;
  std::ofstream(folder.File("a.csv"), std::ios::binary) << csv.body;
  std::FILE* pipe = ::popen(("sha256sum " + folder.File("a.csv")).c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::array<char, 65> sum{};
  EXPECT_EQ(std::fread(sum.data(), 1, 64, pipe), 64U);
  ::pclose(pipe);
  EXPECT_THAT(PdfReader(File("ann", id, "report.pdf").body).Text(), HasSubstr(sum.data()));
}

TEST_F(ReportApiTest, ARunThatGoesOnHasNoReportYet) {
  const json::object run = Expect(201, "ann", "POST runs", R"({"duration_s":600})");
  const std::string id = server::Id(run);
  const HttpAnswer refused = File("ann", id, "report.pdf");
  EXPECT_EQ(refused.status, 409);
  EXPECT_THAT(refused.body, HasSubstr("when the run has ended"));
  Expect(202, "ann", "POST runs/" + id + "/stop", "{}");
  WaitForRun(id);
  EXPECT_THAT(PdfReader(File("ann", id, "report.pdf").body).Text(), HasSubstr("stopped"));
}

/// The report knows the events of the run's JSON and no other source of the truth; these only when
/// the owner asks.
TEST_F(ReportApiTest, ShowsNoMoreFaultsThanTheRunsJson) {
  const std::string id = Run(
      "ann",
      R"({"duration_s":8,"hidden_faults":true,"faults":[{"component":"R1","value":100,"at_s":6}]})");
  const json::object run = Expect(200, "ann", "GET runs/" + id);
  bool told = false;
  for (const json::value& event : run.at("events").as_array()) {
    told = told || event.at("kind") == "relay_confirmed";
  }
  const auto tells = [&](const std::string& query) {
    const std::string text = PdfReader(File("ann", id, "report.pdf" + query).body).Text();
    return text.find(Squeezed("600 R1 100 Ω confirmed")) != std::string::npos;
  };
  EXPECT_FALSE(tells(""));
  EXPECT_EQ(tells("?truth=include"), told);
  for (const char* file : {"report.pdf", "export.csv", "export.json", "plots/swa.png"}) {
    const HttpAnswer answer = Call("ann", "GET runs/" + id + "/" + file);
    EXPECT_THAT(answer.Header("Content-Disposition"), Not(HasSubstr("R1"))) << file;
  }
  EXPECT_EQ(File("bob", id, "report.pdf").status, 404);
}

TEST_F(ReportApiTest, NamesItsFilesForWhatTheyAre) {
  const std::string id =
      Run("ann", R"({"duration_s":3,"faults":[{"component":"R1","value":100,"at_s":2}]})");
  const auto name = [&](const std::string& file) {
    return File("ann", id, file).Header("Content-Disposition");
  };
  EXPECT_THAT(name("export.csv"), HasSubstr("_R1_samples.csv\""));
  EXPECT_THAT(name("export.csv?content=estimates"), HasSubstr("_R1_estimates.csv\""));
  EXPECT_THAT(name("export.mat"), HasSubstr("_R1_samples-estimates.mat\""));
  EXPECT_THAT(name("plots/swa.png?scale=1"), HasSubstr("_R1_swa.png\""));
  EXPECT_THAT(name("plots/swa.png?scale=2"), HasSubstr("_R1_swa_2x.png\""));
}

TEST_F(ReportApiTest, ExportsTheEstimatesOfEverySample) {
  const std::string id = Run("ann", R"({"duration_s":3})");
  std::istringstream lines(File("ann", id, "export.csv?content=estimates").body);
  std::string line;
  std::getline(lines, line);
  EXPECT_THAT(line, StartsWith("# faultlab run " + id));
  std::getline(lines, line);
  EXPECT_THAT(line, StartsWith("index,t_s,swa_50_b0d,swa_50_b1d,swa_50_a1d,swa_50_b0d_sigma,"));
  const auto columns = std::count(line.begin(), line.end(), ',');
  EXPECT_EQ(columns, 2 + 6 * 7 - 1);
  int rows = 0;
  std::string last;
  while (std::getline(lines, line)) {
    last = line;
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns);
    if (rows++ > 0) continue;
    EXPECT_THAT(line, StartsWith("0,0,,,,,,,invalid,"));
  }
  EXPECT_EQ(rows, 300);
  EXPECT_THAT(last, HasSubstr("excited"));
  EXPECT_EQ(File("ann", id, "export.csv?content=all").status, 400);
}

TEST_F(ReportApiTest, TheExampleInPythonReadsWhatIsDownloaded) {
  const std::string id = Run("ann", R"({"duration_s":3})");
  TempFolder folder;
  const auto keep = [&](const char* name, const std::string& file) {
    std::ofstream(folder.File(name), std::ios::binary) << File("ann", id, file).body;
  };
  keep("samples.csv", "export.csv");
  keep("estimates.csv", "export.csv?content=estimates");
  const std::string program =
      "import sys; sys.path.insert(0, '" + tests::InSource("deploy/examples") +
      "')\n"
      "import numpy, load_run\n"
      "run = load_run.read_csv('samples.csv')\n"
      "assert len(run['t_s']) == 300 and abs(run['uc_v'].mean() - 2.5) < 0.1\n"
      "assert any(c.startswith('bench ') for c in run['comments']), run['comments']\n"
      "found = load_run.read_csv('estimates.csv')\n"
      "assert numpy.isnan(found['sia_100_20_b0'][0])\n"
      "assert found['sia_100_20_status'][-1] == 'excited'\n"
      "assert 2.2 < found['sia_100_20_b0'][-1] < 2.6, found['sia_100_20_b0'][-1]\n"
      "load_run.main(['samples.csv', 'estimates.csv'])\n";
  std::ofstream(folder.File("check.py")) << program;
  const std::string command =
      "cd " + folder.path().string() + " && PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 check.py";
  EXPECT_EQ(std::system(command.c_str()), 0) << "packages python3, python3-numpy";
}

}  // namespace
}  // namespace faultlab::tests
