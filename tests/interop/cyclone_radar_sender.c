/* A radar's program with another vendor's DDS (Eclipse Cyclone DDS): writes range/radar_tspi from idl/downrange.idl.
 *
 * cyclone_radar_sender DOMAIN SENSOR TARGET PERIOD_MS: one plot every PERIOD_MS until it is killed. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "dds/dds.h"
#include "downrange.h"

static int64_t utc_now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* What the profile `range/radar_tspi` of config/dds-qos.xml offers. */
static dds_qos_t* radar_qos(void) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 64);
  return qos;
}

int main(int argc, char** argv) {
  if (argc != 5) {
    fprintf(stderr, "usage: %s DOMAIN SENSOR TARGET PERIOD_MS\n", argv[0]);
    return 2;
  }
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)strtoul(argv[1], NULL, 10), NULL, NULL);
  dds_qos_t* qos = radar_qos();
  const dds_entity_t topic =
      dds_create_topic(participant, &downrange_wire_RadarTspiV2_desc, "range/radar_tspi", NULL, NULL);
  const dds_entity_t writer = dds_create_writer(participant, topic, qos, NULL);
  dds_delete_qos(qos);
  if (participant < 0 || topic < 0 || writer < 0) {
    fprintf(stderr, "DDS domain %s cannot be opened: %s\n", argv[1], dds_strretcode(writer));
    return 2;
  }
  downrange_wire_RadarTspiV2 plot = {0};
  strncpy(plot.sensor_id, argv[2], sizeof plot.sensor_id - 1);
  strncpy(plot.target_id, argv[3], sizeof plot.target_id - 1);
  plot.range_m = 100e3;
  plot.azimuth_rad = 3;
  plot.elevation_rad = 0.5;
  plot.range_valid = plot.azimuth_valid = plot.elevation_valid = true;
  plot.mode = downrange_wire_TRACK_MODE_TRACK;
  const dds_duration_t period = DDS_MSECS(strtol(argv[4], NULL, 10));
  for (;;) {
    ++plot.sequence_number;
    plot.epoch_ns = utc_now_ns();
    const dds_return_t written = dds_write(writer, &plot);
    if (written < 0) fprintf(stderr, "plot %s not written\n", dds_strretcode(written));
    dds_sleepfor(period);
  }
}
