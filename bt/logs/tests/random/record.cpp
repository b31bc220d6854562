// Ticks each tree of a file with BehaviorTree.CPP and its FileLogger2: the logs in 4.10.0.gz.
//
//   python3 generate.py 1 1000 > trees.txt
//   c++ -std=c++17 record.cpp -lbehaviortree_cpp -o record      (see ../captured/writer.cpp)
//   ./record trees.txt 500 logs && gzip -9n logs
//   STEWARD_LOGS=$PWD/logs.gz cargo test -p tree_logs --test main random
//
// For each tree, there is a line with its XML, the length of its log in decimal, a line feed, and the log. Trees that
// the library refuses, or in which an exception is thrown, are left out and counted.
#include <behaviortree_cpp/bt_factory.h>
#include <behaviortree_cpp/loggers/bt_file_logger_v2.h>

#include <chrono>
#include <fstream>
#include <iostream>
#include <sstream>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

using namespace BT;

constexpr int TICKS = 12;

// A leaf that gives one answer of its port at each tick: running, success, failure or skipped; then it begins again.
template <typename Base>
struct Leaf : Base {
  using Base::Base;
  static PortsList providedPorts() { return {InputPort<std::string>("answers")}; }
  NodeStatus tick() override {
    const auto answers = Base::template getInput<std::string>("answers").value();
    switch (answers[next_++ % answers.size()]) {
      case 'r': return NodeStatus::RUNNING;
      case 's': return NodeStatus::SUCCESS;
      case 'f': return NodeStatus::FAILURE;
      default: return NodeStatus::SKIPPED;
    }
  }
  size_t next_ = 0;
};

struct Scripted : Leaf<ActionNodeBase> {
  using Leaf::Leaf;
  void halt() override { resetStatus(); }
};

static void record(const std::string& xml, const std::string& file) {
  BehaviorTreeFactory factory;
  factory.registerNodeType<Scripted>("Scripted");
  factory.registerNodeType<Leaf<ConditionNode>>("Look");
  factory.registerBehaviorTreeFromText(xml);
  auto tree = factory.createTree("T");
  FileLogger2 logger(tree, file);
  for (int tick = 0; tick < TICKS; ++tick) {
    tree.tickOnce();
  }
  tree.haltTree();
  // What is queued when the logger ends is lost.
  std::this_thread::sleep_for(std::chrono::milliseconds(40));
}

int main(int, char** words) {
  std::ifstream trees(words[1]);
  std::ofstream logs(words[3], std::ios::binary);
  std::string xml;
  int left_out = 0;
  for (int count = std::atoi(words[2]); count > 0 && std::getline(trees, xml);) {
    // An exception may be thrown again when the tree is destroyed, which ends the process.
    const pid_t child = fork();
    if (child == 0) {
      record(xml, "record.btlog");
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (status != 0) {
      ++left_out;
      continue;
    }
    std::ostringstream log;
    log << std::ifstream("record.btlog", std::ios::binary).rdbuf();
    logs << xml << '\n' << log.str().size() << '\n' << log.str();
    --count;
  }
  std::cout << left_out << " trees left out\n";
}
