/* antenna_client_cyclonedds DOMAIN ANTENNA SECONDS: the program of antenna_client with another vendor's DDS, Eclipse
 * Cyclone DDS.
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

/* What the profile `stream` has. */
static dds_qos_t* stream_qos(void) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 64);
  return qos;
}

/* Takes what has come for `antenna`; how many commands. */
static int take_commands(dds_entity_t reader, const char* antenna, struct steering* axes) {
  void* samples[batch] = {NULL};
  dds_sample_info_t infos[batch];
  const dds_return_t taken = dds_take(reader, samples, infos, batch, batch);
  int commands = 0;
  for (dds_return_t i = 0; i < taken; ++i) {
    const downrange_wire_SlavingCommandV4* c = samples[i];
    if (!infos[i].valid_data || strcmp(c->antenna_id, antenna) != 0) continue;
    const struct steering_command command = {c->tick_ns,
                                             c->apply_at_ns,
                                             c->valid_until_ns,
                                             c->azimuth_rad,
                                             c->elevation_rad,
                                             c->azimuth_rate_rad_s,
                                             c->elevation_rate_rad_s,
                                             c->acceleration_valid,
                                             c->azimuth_acceleration_rad_s2,
                                             c->elevation_acceleration_rad_s2};
    steering_take(axes, command, utc_now_ns());
    ++commands;
  }
  if (taken > 0) dds_return_loan(reader, samples, taken);
  return commands;
}

/* Where the encoders say that it points. `simulated` stays false: a service that flies a rehearsal passes over it. */
static void report(dds_entity_t writer, downrange_wire_AntennaReportV2* sample, const struct mount* axes) {
  ++sample->sequence_number;
  sample->epoch_ns = utc_now_ns();
  sample->azimuth_rad = axes->azimuth_rad;
  sample->elevation_rad = axes->elevation_rad;
  sample->azimuth_valid = true;
  sample->elevation_valid = true;
  sample->mode = axes->follows ? downrange_wire_ANTENNA_SLAVED : downrange_wire_ANTENNA_MANUAL;
  sample->command_tick_ns = axes->tick_ns;
  if (dds_write(writer, sample) < 0) fprintf(stderr, "a report could not be written\n");
}

static int follow(dds_entity_t reader, dds_entity_t writer, const char* antenna, int seconds) {
  struct steering commands = {0};
  struct mount axes = {0};
  downrange_wire_AntennaReportV2 sample = {0};
  snprintf(sample.antenna_id, sizeof sample.antenna_id, "%s", antenna);
  int taken = 0;
  for (int step = 0; step < 1000 / servo_step_ms * seconds; ++step) {
    taken += take_commands(reader, antenna, &commands);
    mount_step(&axes, &commands, utc_now_ns(), step);
    if (step % report_every == 0) report(writer, &sample, &axes);
    dds_sleepfor(DDS_MSECS(servo_step_ms));
  }
  printf("%d commands to %s\n", taken, antenna);
  return taken > 0 ? 0 : 1;
}

int main(int argc, char** argv) {
  if (argc != 4) {
    fprintf(stderr, "usage: %s DOMAIN ANTENNA SECONDS\n", argv[0]);
    return 2;
  }
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  const dds_entity_t commands =
      dds_create_topic(participant, &downrange_wire_SlavingCommandV4_desc, "downrange/slaving", NULL, NULL);
  const dds_entity_t reports =
      dds_create_topic(participant, &downrange_wire_AntennaReportV2_desc, "range/antenna", NULL, NULL);
  dds_qos_t* reader_qos = slaving_client_qos();
  dds_qos_t* writer_qos = stream_qos();
  const dds_entity_t reader = dds_create_reader(participant, commands, reader_qos, NULL);
  const dds_entity_t writer = dds_create_writer(participant, reports, writer_qos, NULL);
  dds_delete_qos(reader_qos);
  dds_delete_qos(writer_qos);
  if (reader < 0 || writer < 0) {
    fprintf(stderr, "DDS domain %s cannot be opened: %s\n", argv[1], dds_strretcode(reader < 0 ? reader : writer));
    return 2;
  }
  const int status = follow(reader, writer, argv[2], atoi(argv[3]));
  dds_delete(participant);
  return status;
}
