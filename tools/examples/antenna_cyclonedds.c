/* antenna_cyclonedds DOMAIN ANTENNA SECONDS: the same antenna's program with another vendor's DDS, Eclipse Cyclone DDS.
 * Exit status 1: no command to this antenna has come. */

#include <stdlib.h>

#include "dds/dds.h"
#include "downrange.h"
#include "steering.h"

enum { batch = 16 };

/* What the profile `slaving-client` of dds-qos.xml asks for. */
static dds_qos_t* slaving_client_qos(void) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 16);
  dds_qset_ownership(qos, DDS_OWNERSHIP_EXCLUSIVE);
  dds_qset_liveliness(qos, DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(200));
  dds_qset_deadline(qos, DDS_MSECS(100));
  return qos;
}

/* Takes what has come for `antenna`; how many commands. */
static int take_commands(dds_entity_t reader, const char* antenna, struct steering* axes) {
  void* samples[batch] = {NULL};
  dds_sample_info_t infos[batch];
  const dds_return_t taken = dds_take(reader, samples, infos, batch, batch);
  int commands = 0;
  for (dds_return_t i = 0; i < taken; ++i) {
    const downrange_wire_SlavingCommandV2* c = samples[i];
    if (!infos[i].valid_data || strcmp(c->antenna_id, antenna) != 0) continue;
    const struct steering_command command = {c->apply_at_ns,   c->valid_until_ns,     c->azimuth_rad,
                                             c->elevation_rad, c->azimuth_rate_rad_s, c->elevation_rate_rad_s};
    steering_take(axes, command);
    ++commands;
  }
  if (taken > 0) dds_return_loan(reader, samples, taken);
  return commands;
}

int main(int argc, char** argv) {
  if (argc != 4) {
    fprintf(stderr, "usage: %s DOMAIN ANTENNA SECONDS\n", argv[0]);
    return 2;
  }
  const char* antenna = argv[2];
  const int seconds = atoi(argv[3]);
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  const dds_entity_t topic =
      dds_create_topic(participant, &downrange_wire_SlavingCommandV2_desc, "downrange/slaving", NULL, NULL);
  dds_qos_t* qos = slaving_client_qos();
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, NULL);
  dds_delete_qos(qos);
  if (participant < 0 || topic < 0 || reader < 0) {
    fprintf(stderr, "DDS domain %s cannot be opened: %s\n", argv[1], dds_strretcode(reader));
    return 2;
  }
  struct steering axes = {0};
  int commands = 0;
  bool follows = false;
  for (int step = 0; step < 100 * seconds; ++step) {
    commands += take_commands(reader, antenna, &axes);
    follows = steering_step(&axes, follows, step);
    dds_sleepfor(DDS_MSECS(10));
  }
  printf("%d commands to %s\n", commands, antenna);
  dds_delete(participant);
  return commands > 0 ? 0 : 1;
}
