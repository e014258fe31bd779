#include "tests/support/postgres_cluster.h"
#include "tests/support/await.h"

#include <fcntl.h>
#include <grp.h>
#include <libpq-fe.h>
#include <pwd.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <stdexcept>
#include <vector>

namespace faultlab::tests {
namespace {

std::string Program(const std::string& name) {
  for (const char* folder : {"/usr/lib/postgresql/15/bin/", "/usr/lib/postgresql/16/bin/"}) {
    if (access((folder + name).c_str(), X_OK) == 0) return folder + name;
  }
  throw std::runtime_error("PostgreSQL's " + name + " is not installed (Debian: postgresql-15)");
}

const passwd* ServerUser() {
  if (geteuid() != 0) return nullptr;
  const passwd* user = getpwnam("postgres");
  return user != nullptr ? user : getpwnam("nobody");
}

/// Forks and runs a program as the server's user, its output in `log`; it dies with this process.
pid_t Start(const std::vector<std::string>& arguments, const std::string& log) {
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const passwd* user = ServerUser();
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child != 0) return child;
  const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  if (user != nullptr &&
      (setgroups(0, nullptr) != 0 || setgid(user->pw_gid) != 0 || setuid(user->pw_uid) != 0)) {
    _exit(126);
  }
  prctl(PR_SET_PDEATHSIG, SIGQUIT);
  if (getppid() != parent || chdir("/") != 0) _exit(126);
  execv(argv[0], argv.data());
  _exit(127);
}

}  // namespace

PostgresCluster& PostgresCluster::Instance() {
  static PostgresCluster cluster;
  return cluster;
}

PostgresCluster::PostgresCluster() {
  std::string pattern = std::filesystem::temp_directory_path() / "faultlab-pg-XXXXXX";
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
  folder_ = pattern;
  const passwd* user = ServerUser();
  if (user != nullptr && chown(folder_.c_str(), user->pw_uid, user->pw_gid) != 0) {
    throw std::runtime_error("chown failed");
  }
  const std::string data = folder_ + "/data";
  const std::string log = folder_ + "/log";
  int status = 0;
  waitpid(Start({Program("initdb"),
                 "--pgdata=" + data,
                 "--no-sync",
                 "--auth=trust",
                 "--username=postgres",
                 "--encoding=UTF8",
                 "--locale=C"},
                log),
          &status,
          0);
  if (status != 0) throw std::runtime_error("initdb failed, see " + log);
  server_ = Start({Program("postgres"),
                   "-D",
                   data,
                   "-c",
                   "listen_addresses=",
                   "-c",
                   "unix_socket_directories=" + folder_,
                   "-c",
                   "fsync=off",
                   "-c",
                   "max_connections=100"},
                  log);
  const std::string connection = "host=" + folder_ + " user=postgres dbname=postgres";
  bool ended = false;
  const bool answered = Await([&] {
    ended = waitpid(server_, nullptr, WNOHANG) != 0;
    return ended || PQping(connection.c_str()) == PQPING_OK;
  });
  if (ended || !answered) throw std::runtime_error("PostgreSQL did not start, see " + log);
}

PostgresCluster::~PostgresCluster() {
  if (server_ > 0) {
    kill(server_, SIGQUIT);
    waitpid(server_, nullptr, 0);
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void PostgresCluster::Execute(const std::string& statement) const {
  PGconn* connection = PQconnectdb(("host=" + folder_ + " user=postgres dbname=postgres").c_str());
  PGresult* result = PQexec(connection, statement.c_str());
  const ExecStatusType status = PQresultStatus(result);
  const std::string message = PQerrorMessage(connection);
  PQclear(result);
  PQfinish(connection);
  if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) throw std::runtime_error(message);
}

std::string PostgresCluster::CreateDatabase() {
  const std::string name = "test_" + std::to_string(++databases_);
  Execute("CREATE DATABASE " + name);
  return "postgresql:host=" + folder_ + " user=postgres dbname=" + name;
}

void PostgresCluster::KillConnections() {
  Execute(
      "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
      "WHERE pid <> pg_backend_pid() AND datname LIKE 'test_%'");
}

}  // namespace faultlab::tests
