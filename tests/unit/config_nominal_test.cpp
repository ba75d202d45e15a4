/// Planned trajectories of targets: CSV files, their problems by file and line, rows in the configuration in force.
#include <gtest/gtest.h>
#include <unistd.h>

#include <downrange/geo/site.hpp>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "config/load.hpp"
#include "config/nominal.hpp"

namespace downrange::config {
namespace {

constexpr double deg = std::numbers::pi / 180;

struct Read {
  std::optional<NominalTrajectory> nominal;
  std::string problem;  ///< "3: what"
};

Read read(const std::string& text, const NominalFormat& format = {}) {
  Read result;
  result.nominal = read_nominal_csv(text, format, [&](int line, const std::string& message) {
    result.problem += std::to_string(line) + ": " + message;
  });
  EXPECT_NE(result.nominal.has_value(), !result.problem.empty()) << text;
  return result;
}

TEST(NominalCsv, EarthFixedWithVelocities) {
  const Read plan =
      read("# plan 7\n\nt_s,x_km,y_m,z_m,vx_km_s,vy_m_s,vz_m_s\n-1,6400,1,2,0.1,4,5\n+10.5, 6401.5 ,3,4,0.2,5,6\n");
  ASSERT_TRUE(plan.nominal) << plan.problem;
  ASSERT_EQ(plan.nominal->samples().size(), 2u);
  EXPECT_EQ(plan.nominal->samples()[1].t_s, 10.5);
  EXPECT_EQ(plan.nominal->samples()[1].state.position.m, Eigen::Vector3d(6'401'500, 3, 4));
  EXPECT_EQ(plan.nominal->samples()[1].state.velocity.m_s, Eigen::Vector3d(200, 5, 6));
}

TEST(NominalCsv, GeodeticWithoutVelocities) {
  const Read plan =
      read("t_ms;latitude_deg;longitude_deg;height_km\r\n0;34;127;0.1\r\n1000;34;127;0.2\r\n2000;34;127;0.4\r\n");
  ASSERT_TRUE(plan.nominal) << plan.problem;
  const NominalSample& middle = plan.nominal->samples()[1];
  EXPECT_EQ(middle.t_s, 1);
  EXPECT_LT((middle.state.position.m - ecef_from_geodetic({34 * deg, 127 * deg, 200}).m).norm(), 1e-6);
  EXPECT_NEAR(middle.state.velocity.m_s.norm(), 150, 1e-3) << "from its neighbours";
}

TEST(NominalCsv, SeveralObjectsAndNamesOfColumns) {
  const std::string text =
      "object\tt_s\tx_m\ty_m\tz_"
      "m\nA\t0\t6400000\t0\t0\nB\t0\t6500000\t0\t0\nA\t1\t6400100\t0\t0\nB\t1\t6500100\t0\t0\n";
  EXPECT_EQ(read(text, {.object = "B"}).nominal->samples().front().state.position.m.x(), 6.5e6);
  EXPECT_EQ(read(text, {.object = "C"}).problem,
            "0: no row of object 'C'; there are: A, B (nominal_object says which; default: the target's id)");
  const NominalFormat named{.columns = {"-", "t_s", "x_km", "y_km", "z_km"}};
  EXPECT_EQ(read("mass,T,X,Y,Z\n1,0,6400,0,0\n1,1,6401,0,0\n", named).nominal->samples().size(), 2u);
  EXPECT_EQ(read("1,0,6400,0,0\n1,1,6401,0,0\n", named).nominal->samples().size(), 2u) << "a file without names";
}

TEST(NominalCsv, ProblemsNameTheLine) {
  const std::string head = "t_s,x_m,y_m,z_m\n0,6400000,0,0\n";
  const auto expect = [](const std::string& text, const std::string& start) {
    EXPECT_EQ(read(text).problem.substr(0, start.size()), start) << text;
  };
  expect("", "0: no line of column names; columns: t_s, ");
  expect("t_s,x,y_m,z_m\n", "1: column 'x' is not known; columns: t_s, ");
  expect("t_s,x_m,y_m\n", "1: needs a column of time, and either three of Earth-fixed or");
  expect("t_s,x_m,y_m,z_m,vx_m_s\n", "1: has only some of vx, vy, vz");
  expect("t_s,t_ms,x_m,y_m,z_m\n", "1: column 't_ms' is there twice");
  expect(head + "1,6400000,0\n", "3: 3 fields instead of 4");
  expect(head + "1,six,0,0\n", "3: x_m: 'six' is not a number");
  expect(head + "1,nan,0,0\n", "3: x_m: 'nan' is not a number");
  expect(head + "1,6400,0,0\n", "3: a position 6.400000 km from the Earth's centre");
  expect(head + "0,6400000,0,0\n", "3: its time is not after that of the row before");
  expect(head + "0.001,6400100,0,0\n", "3: moves by 100.000000 km/s");
  expect(head, "0: fewer than two samples");
  expect("t_s,latitude_deg,longitude_deg,height_m\n0,100,0,0\n", "2: latitude beyond a pole");
  std::string many = "t_s,x_m,y_m,z_m\n";
  for (std::size_t i = 0; i <= max_nominal_samples; ++i) many += std::to_string(i) + ",6400000,0,0\n";
  expect(many, "20002: more than 20000 samples");
}

class NominalKey : public testing::Test {
 protected:
  NominalKey() { std::filesystem::create_directories(folder_); }
  ~NominalKey() override { std::filesystem::remove_all(folder_); }
  /// A configuration with `keys` in its target.
  ServiceConfig load_with(const std::string& keys) {
    std::ofstream(folder_ / "range.toml")
        << "[range]\nname = \"r\"\n[[target]]\nid = \"t\"\n" + keys +
               "\n[[telemetry]]\nid = \"tm\"\nlatitude_deg = 1\nlongitude_deg = 1\nheight_m = 1\n";
    return load(folder_ / "range.toml");
  }
  std::string problem_with(const std::string& keys) {
    try {
      static_cast<void>(load_with(keys));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  void write(const std::string& text) { std::ofstream(folder_ / "plan.csv") << text; }

  std::filesystem::path folder_ = std::filesystem::temp_directory_path() / ("nominal-test-" + std::to_string(getpid()));
};

TEST_F(NominalKey, AFileBesideTheConfigurationIsRead) {
  write("object,t_s,x_m,y_m,z_m\nt,0,6400000,0.1,0\nt,1,6400100,0.3,0\n");
  const ServiceConfig config = load_with("nominal = \"plan.csv\"");
  ASSERT_EQ(config.range.targets.at(0).nominal.samples().size(), 2u);
  // The configuration in force has the rows: it loads the same where the file is not.
  const ServiceConfig again = load_text(config.text, "elsewhere.toml");
  EXPECT_EQ(again.range.targets.at(0).nominal, config.range.targets.at(0).nominal) << config.text;
  EXPECT_TRUE(differences(config, again).empty());
  write("object,t_s,x_m,y_m,z_m\nt,0,6400000,0.2,0\nt,1,6400100,0.3,0\n");
  EXPECT_EQ(differences(config, load_with("nominal = \"plan.csv\"")), std::vector<std::string>{"target[0].nominal"});
  EXPECT_TRUE(load_with("").range.targets.at(0).nominal.empty());
  EXPECT_TRUE(load_with("nominal = \"\"").range.targets.at(0).nominal.empty());
}

TEST_F(NominalKey, ProblemsNameFileAndLine) {
  EXPECT_NE(
      problem_with("nominal = \"plan.csv\"").find("range.toml:5: target[0].nominal: found \"plan.csv\", no such file"),
      std::string::npos);
  write("t_s,x_m,y_m,z_m\n0,6400000,0,0\n1,x,0,0\n");
  EXPECT_NE(problem_with("nominal = \"plan.csv\"").find("plan.csv:3: x_m: 'x' is not a number"), std::string::npos);
  EXPECT_NE(
      problem_with("nominal = 7").find("target[0].nominal: found 7 (whole number), allowed: the path of a CSV file"),
      std::string::npos);
  EXPECT_NE(problem_with("nominal = [[0, 1], [1, 2]]").find("target[0].nominal: found"), std::string::npos);
  EXPECT_NE(problem_with("nominal = \".\"").find("is a folder, not a file"), std::string::npos);
}

}  // namespace
}  // namespace downrange::config
