import sys,time,json,pickle
from dataclasses import replace
from cdpr_interval import load_robot
from solvers.forward import answer_question, pose_problem
from solvers.problem import Options
from solvers.certificate_entries import Record, subset_entries
from solvers.certificate_point import widened, certificate_question
import numpy as np
name,ls=sys.argv[1],sys.argv[2]; taut=sys.argv[3] if len(sys.argv)>3 and sys.argv[3]!='-' else None
rec=Record(); o=Options(record=rec,threads=2)
r=load_robot(name); pr=pose_problem(r,ls,taut,None,o)
res=answer_question(pr,o); print(res.message)
sols=[widened(s) for s in res.solutions if s.family is None or s.family.kind!='torus']
t=time.process_time(); es=subset_entries(pr,o,rec,sols); print('write',round(time.process_time()-t,1))
import flint
from certificates.subsets import classify, examined
from certificates.searches import Searches
from certificates.point_mass import check_point
from certificates.families import check_one_point_family
from certificates.verdicts import *
from solvers.certificate_point import listed_solution
from collections import Counter
q=certificate_question(pr,o); L=[listed_solution(s) for s in sols]; back=set(); import random
flint.ctx.prec=200
N=int(sys.argv[4]) if len(sys.argv)>4 else 10**9
tot=Counter(); t=time.process_time()
for taut,e in zip(examined(q),es):
    k=classify(q,taut)
    if 'pending' in e or len(e)==1: print(taut,k,e); continue
    if 'point' in e: b=check_one_point_family(q,taut,e['point'],L); print(taut,'point',b); back|=b; continue
    s=Searches(q,taut,k,e['searches'],L); b=s.check_roots(); back|=b
    lv=s.leaves if len(s.leaves)<=N else random.Random(1).sample(s.leaves,N)
    c=Counter(l.node.name for _,l in s.leaves); p=0; t1=time.process_time()
    for x in lv:
        try: p+=s.check(x)
        except NotProved as ex: print('BAD',taut,ex)
    dt=time.process_time()-t1
    print(taut,k,b,dict(c),'roots',[(x.chart,x.pose,x.end) for se in s.searches for x in se.roots],'parts',p,'of',len(lv),'s',round(dt,1),'est',round(dt*len(s.leaves)/max(1,len(lv)),1))
print('backed',sorted(back),'of',len(sols), round(time.process_time()-t,1),'s')
json.dump(es,open(f'/tmp/p/cert/e_{name}.json','w'))
